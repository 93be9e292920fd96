// SPDX-License-Identifier: GPL-3.0-only
// A shape model as numbers: shapes from scores, scores from fixed landmarks, distances. Nothing here knows of the page.
//
// Scores are in standard deviations, so that a priori they are independent standard normal. Positions are relative to the model's
// centre (data.centre), so that 32-bit floats have digits enough wherever the coordinates lie; 3 N numbers, x y z of each landmark.

/** Numbers as the page carries them: base64 of little-endian numbers; `scales`, one per row, where these were made integers. */
function decoded(packed) {
  const bytes = Uint8Array.from(atob(packed.base64), (letter) => letter.charCodeAt(0));
  const kinds = { float32: Float32Array, int16: Int16Array, uint16: Uint16Array, int32: Int32Array, uint8: Uint8Array };
  const numbers = new kinds[packed.type](bytes.buffer);
  if (!packed.scales) return numbers;
  const row = numbers.length / packed.scales.length;
  return Float32Array.from(numbers, (number, i) => number * packed.scales[Math.floor(i / row)]);
}

class ShapeModel {
  /** data: what explorer.py puts into the page. */
  constructor(data) {
    this.landmarks = data.landmarks;
    this.modes = data.modes;
    this.names = data.names;
    this.centre = data.centre;
    this.mean = decoded(data.mean);
    this.directions = decoded(data.directions); // modes x 3 N: what one standard deviation moves
    this.faces = decoded(data.faces);
    this.normals = vertexNormals(this.mean, this.faces);
    const scores = decoded(data.scores);
    this.scores = data.names.map((_, k) => scores.subarray(k * this.modes, (k + 1) * this.modes));
  }

  /** Writes the shape with these scores to `shape`. */
  shape(scores, shape = new Float64Array(this.mean.length)) {
    shape.set(this.mean);
    for (let m = 0; m < this.modes; ++m) {
      const score = scores[m];
      if (score === 0) continue;
      const start = m * shape.length;
      for (let i = 0; i < shape.length; ++i) shape[i] += score * this.directions[start + i];
    }
    return shape;
  }

  /**
   * What the model expects of the scores once some landmarks are known but for an error of standard deviation `noise` per
   * coordinate. fixed: [{index, target}], target relative to the centre. With D the rows of the directions at these landmarks and
   * d = target - mean, scores b ~ N(0, I) and errors N(0, noise^2 I), the posterior is normal (C. M. Bishop, Pattern Recognition
   * and Machine Learning, 2006, eq. 2.116) with
   *
   *   precision  P = D'D / noise^2 + I,   mean  b = P^-1 D'd / noise^2.
   *
   * Returns {scores, factor}; factor is the lower triangle L of P = L L'.
   */
  posterior(fixed, noise) {
    const size = this.modes, precision = new Float64Array(size * size), right = new Float64Array(size);
    const weight = 1 / (noise * noise), row = new Float64Array(size);
    for (let m = 0; m < size; ++m) precision[m * size + m] = 1;
    for (const { index, target } of fixed) {
      for (let axis = 0; axis < 3; ++axis) {
        const i = 3 * index + axis, distance = target[axis] - this.mean[i];
        for (let m = 0; m < size; ++m) row[m] = this.directions[m * this.mean.length + i];
        for (let m = 0; m < size; ++m) {
          right[m] += weight * row[m] * distance;
          for (let k = 0; k <= m; ++k) precision[m * size + k] += weight * row[m] * row[k];
        }
      }
    }
    const factor = choleskyFactor(precision, size);
    return { scores: backward(factor, size, forward(factor, size, right)), factor };
  }

  /** Per landmark the standard deviation of its place, sqrt(trace of its covariance D P^-1 D'); factor: of `posterior`. Mode by mode,
   * so that memory is read in its order: it is done anew in each picture while a landmark is dragged. */
  uncertainty(factor) {
    const size = this.modes, sd = new Float64Array(this.landmarks), row = new Float64Array(this.mean.length);
    const columns = Array.from({ length: size }, (_, k) => forward(factor, size, Float64Array.from({ length: size }, (__, m) => Number(m === k)))); // of L^-1
    for (let m = 0; m < size; ++m) {
      row.fill(0);
      for (let k = 0; k <= m; ++k) {
        const share = columns[k][m], start = k * row.length;
        for (let i = 0; i < row.length; ++i) row[i] += share * this.directions[start + i];
      }
      for (let i = 0; i < row.length; ++i) sd[Math.floor(i / 3)] += row[i] * row[i];
    }
    return sd.map(Math.sqrt);
  }

  /** Per landmark how far `shape` lies from `reference`; along the reference's normals, outwards positive, where they are given. */
  distances(shape, reference, normals, distances = new Float64Array(this.landmarks)) {
    for (let j = 0, i = 0; j < this.landmarks; ++j, i += 3) {
      const x = shape[i] - reference[i], y = shape[i + 1] - reference[i + 1], z = shape[i + 2] - reference[i + 2];
      distances[j] = normals ? x * normals[i] + y * normals[i + 1] + z * normals[i + 2] : Math.sqrt(x * x + y * y + z * z);
    }
    return distances;
  }
}

/** The Mahalanobis distance from the mean, of scores in standard deviations. */
function mahalanobis(scores) {
  return Math.sqrt(scores.reduce((sum, score) => sum + score * score, 0));
}

/** L of L L' = a symmetric positive definite matrix, of which the lower triangle is read. */
function choleskyFactor(matrix, size) {
  const factor = new Float64Array(size * size);
  for (let i = 0; i < size; ++i) {
    for (let j = 0; j <= i; ++j) {
      let sum = matrix[i * size + j];
      for (let k = 0; k < j; ++k) sum -= factor[i * size + k] * factor[j * size + k];
      factor[i * size + j] = i === j ? Math.sqrt(sum) : sum / factor[j * size + j];
    }
  }
  return factor;
}

/** L^-1 right. */
function forward(factor, size, right) {
  const solution = new Float64Array(size);
  for (let i = 0; i < size; ++i) {
    let sum = right[i];
    for (let k = 0; k < i; ++k) sum -= factor[i * size + k] * solution[k];
    solution[i] = sum / factor[i * size + i];
  }
  return solution;
}

/** L'^-1 right. */
function backward(factor, size, right) {
  const solution = new Float64Array(size);
  for (let i = size - 1; i >= 0; --i) {
    let sum = right[i];
    for (let k = i + 1; k < size; ++k) sum -= factor[k * size + i] * solution[k];
    solution[i] = sum / factor[i * size + i];
  }
  return solution;
}

/** Unit normals of vertices: the sum of the faces' around them, each as long as its area. */
function vertexNormals(points, faces, normals = new Float32Array(points.length)) {
  normals.fill(0);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (const corner of [a, b, c]) {
      normals[corner] += x;
      normals[corner + 1] += y;
      normals[corner + 2] += z;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.sqrt(normals[i] ** 2 + normals[i + 1] ** 2 + normals[i + 2] ** 2) || 1;
    normals[i] /= length;
    normals[i + 1] /= length;
    normals[i + 2] /= length;
  }
  return normals;
}

/** Where a ray meets the surface first: {index: the corner nearest to that point, point}; null where it passes by.
 * seen: whether a landmark is shown. (T. Moeller, B. Trumbore, Fast, minimum storage ray/triangle intersection, 1997.) */
function pickedLandmark(points, faces, ray, seen) {
  const [ox, oy, oz] = ray.origin, [dx, dy, dz] = ray.direction;
  let nearest = Infinity, face = -1;
  for (let f = 0; f < faces.length; f += 3) {
    if (!seen(faces[f])) continue;
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const px = dy * vz - dz * vy, py = dz * vx - dx * vz, pz = dx * vy - dy * vx;
    const determinant = ux * px + uy * py + uz * pz;
    if (determinant === 0) continue;
    const sx = ox - points[a], sy = oy - points[a + 1], sz = oz - points[a + 2];
    const u = (sx * px + sy * py + sz * pz) / determinant;
    if (u < 0 || u > 1) continue;
    const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
    const v = (dx * qx + dy * qy + dz * qz) / determinant;
    if (v < 0 || u + v > 1) continue;
    const t = (vx * qx + vy * qy + vz * qz) / determinant;
    if (t > 0 && t < nearest) [nearest, face] = [t, f];
  }
  if (face < 0) return null;
  const point = [ox + nearest * dx, oy + nearest * dy, oz + nearest * dz];
  let index = -1, least = Infinity;
  for (const corner of faces.subarray(face, face + 3)) {
    const distance = Math.hypot(...point.map((value, axis) => value - points[3 * corner + axis]));
    if (distance < least) [least, index] = [distance, corner];
  }
  return { index, point };
}
