// SPDX-License-Identifier: GPL-3.0-only
// One triangle mesh in WebGL 2: shaded, coloured by a number per vertex through a palette, its vertices as dots; and the camera that
// looks at it.

/** Looks at the origin of the model from a distance; `turn` (rows: right, up, towards the eye) is how the model stands. */
class Camera {
  constructor(turn, radius) {
    this.home = { turn: [...turn], distance: 4.2 * radius, shift: [0, 0] };
    this.radius = radius;
    this.focal = 3.2; // of a picture 2 high: 35 degrees from bottom to top
    this.reset();
  }

  reset() {
    Object.assign(this, { turn: [...this.home.turn], distance: this.home.distance, shift: [...this.home.shift] });
  }

  /** By angles around the picture's upright axis and its level one. */
  rotate(right, down) {
    const [s, c, u, v] = [Math.sin(right), Math.cos(right), Math.sin(down), Math.cos(down)];
    this.turn = product3([c, 0, s, u * s, v, -u * c, -v * s, u, v * c], this.turn);
  }

  zoom(factor) {
    this.distance = Math.min(Math.max(this.distance * factor, 1.3 * this.radius), 40 * this.radius);
  }

  /** By CSS pixels of a picture of this height. */
  pan(right, down, height) {
    const length = (2 * this.distance) / (this.focal * height);
    this.shift[0] += right * length;
    this.shift[1] -= down * length;
  }

  /** A point of the model as the eye sees it: right, up, and how far in front of the eye. */
  seen([x, y, z]) {
    const t = this.turn;
    return [
      t[0] * x + t[1] * y + t[2] * z + this.shift[0],
      t[3] * x + t[4] * y + t[5] * z + this.shift[1],
      this.distance - (t[6] * x + t[7] * y + t[8] * z),
    ];
  }

  /** The point of the model that is `seen` so. */
  unseen([right, up, front]) {
    const v = [right - this.shift[0], up - this.shift[1], this.distance - front], t = this.turn;
    return [0, 1, 2].map((k) => t[k] * v[0] + t[3 + k] * v[1] + t[6 + k] * v[2]);
  }

  /** CSS pixels of a picture of that size, and how far in front of the eye. */
  project(point, { width, height }) {
    const [right, up, front] = this.seen(point), scale = (this.focal * height) / (2 * front);
    return [width / 2 + right * scale, height / 2 - up * scale, front];
  }

  /** The point of the model so far in front of the eye that CSS pixels show. */
  unproject([x, y], front, { width, height }) {
    const length = (2 * front) / (this.focal * height);
    return this.unseen([(x - width / 2) * length, (height / 2 - y) * length, front]);
  }

  ray(pixel, size) {
    const origin = this.unseen([0, 0, 0]), through = this.unproject(pixel, 1, size);
    return { origin, direction: through.map((value, axis) => value - origin[axis]) };
  }

  /** For WebGL, column by column. */
  matrix({ width, height }) {
    const t = this.turn, near = Math.max(this.distance - 3 * this.radius, 0.02 * this.radius), far = this.distance + 3 * this.radius;
    const x = (this.focal * height) / width, y = this.focal, a = (far + near) / (far - near), b = (2 * far * near) / (near - far);
    const depth = [-t[6], -t[7], -t[8], this.distance]; // in front of the eye
    const rows = [
      [t[0], t[1], t[2], this.shift[0]].map((value) => value * x),
      [t[3], t[4], t[5], this.shift[1]].map((value) => value * y),
      depth.map((value, k) => a * value + (k === 3 ? b : 0)),
      depth,
    ];
    return Float32Array.from({ length: 16 }, (_, k) => rows[k % 4][Math.floor(k / 4)]);
  }
}

function product3(a, b) {
  return Array.from({ length: 9 }, (_, k) => {
    const row = 3 * Math.floor(k / 3), column = k % 3;
    return a[row] * b[column] + a[row + 1] * b[3 + column] + a[row + 2] * b[6 + column];
  });
}

const MESH_VERTEX = `#version 300 es
in vec3 position, normal;
in float value;
uniform mat4 camera;
uniform mat3 turn;
out vec3 facing;
out float at;
void main() {
  facing = turn * normal;
  at = value;
  gl_Position = camera * vec4(position, 1.0);
}`;
const MESH_FRAGMENT = `#version 300 es
precision mediump float;
in vec3 facing;
in float at;
uniform sampler2D palette;
out vec4 color;
void main() {
  vec3 n = normalize(gl_FrontFacing ? facing : -facing);
  float light = max(dot(n, vec3(-0.31, 0.47, 0.83)), 0.0);
  float shine = pow(max(dot(n, vec3(-0.16, 0.245, 0.956)), 0.0), 60.0);
  vec3 base = texture(palette, vec2(at, 0.5)).rgb * (gl_FrontFacing ? 1.0 : 0.6);
  color = vec4(base * (0.52 + 0.46 * light) + 0.08 * shine, 1.0);
}`;
const DOT_VERTEX = `#version 300 es
in vec3 position;
uniform mat4 camera;
uniform float size;
void main() {
  gl_Position = camera * vec4(position, 1.0);
  gl_Position.z -= 0.0015 * gl_Position.w; // in front of the surface that it lies on
  gl_PointSize = size;
}`;
const DOT_FRAGMENT = `#version 300 es
precision mediump float;
out vec4 color;
void main() {
  if (length(gl_PointCoord - 0.5) > 0.5) discard;
  color = vec4(0.07, 0.1, 0.15, 1.0);
}`;

class Renderer {
  /** parts: of each, the faces' corners in a row. Throws where the browser has no WebGL 2. */
  constructor(canvas, landmarks, parts) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
    if (!gl) throw new Error("This browser shows no WebGL 2, which the page needs.");
    Object.assign(this, { canvas, gl, landmarks });
    this.mesh = program(gl, MESH_VERTEX, MESH_FRAGMENT);
    this.dots = program(gl, DOT_VERTEX, DOT_FRAGMENT);
    this.buffers = { position: gl.createBuffer(), normal: gl.createBuffer(), value: gl.createBuffer() };
    this.vertices = gl.createVertexArray();
    gl.bindVertexArray(this.vertices);
    for (const [name, buffer, size] of [["position", this.buffers.position, 3], ["normal", this.buffers.normal, 3], ["value", this.buffers.value, 1]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, 4 * size * landmarks, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(ATTRIBUTES.indexOf(name));
      gl.vertexAttribPointer(ATTRIBUTES.indexOf(name), size, gl.FLOAT, false, 0, 0);
    }
    this.parts = parts.map((corners) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(corners), gl.STATIC_DRAW);
      return { buffer, count: corners.length };
    });
    this.palette = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.palette);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0.96, 0.965, 0.973, 1);
  }

  /** CSS pixels. */
  get size() {
    return { width: this.canvas.clientWidth, height: this.canvas.clientHeight };
  }

  /** colors: [[red, green, blue], ...] in 0 .. 255, evenly spread over the values 0 .. 1. */
  setPalette(colors) {
    const steps = 256, pixels = new Uint8Array(4 * steps);
    for (let i = 0; i < steps; ++i) pixels.set([...between(colors, i / (steps - 1)), 255], 4 * i);
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.palette);
    this.gl.texImage2D(this.gl.TEXTURE_2D, 0, this.gl.RGBA, steps, 1, 0, this.gl.RGBA, this.gl.UNSIGNED_BYTE, pixels);
  }

  /** Numbers per vertex: three, three and one (in 0 .. 1). */
  setShape(positions, normals, values) {
    const gl = this.gl;
    for (const [buffer, numbers] of [[this.buffers.position, positions], [this.buffers.normal, normals], [this.buffers.value, values]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, numbers);
    }
  }

  /** shown: per part, whether it is; dots: CSS pixels of those on the landmarks, 0 for none. */
  draw(camera, shown, dots) {
    const gl = this.gl, ratio = Math.min(window.devicePixelRatio || 1, 2), { width, height } = this.size;
    const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
    if (this.canvas.width !== w || this.canvas.height !== h) Object.assign(this.canvas, { width: w, height: h });
    gl.viewport(0, 0, w, h);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.bindVertexArray(this.vertices);
    const matrix = camera.matrix({ width: w, height: h });
    gl.useProgram(this.mesh.program);
    gl.uniformMatrix4fv(this.mesh.at("camera"), false, matrix);
    gl.uniformMatrix3fv(this.mesh.at("turn"), true, camera.turn);
    this.parts.forEach(({ buffer, count }, part) => {
      if (!shown[part]) return;
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    });
    if (!dots) return;
    gl.useProgram(this.dots.program);
    gl.uniformMatrix4fv(this.dots.at("camera"), false, matrix);
    gl.uniform1f(this.dots.at("size"), dots * ratio);
    gl.drawArrays(gl.POINTS, 0, this.landmarks);
  }

  /** Waits until the picture is there; for measurements. */
  finish() {
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
}

const ATTRIBUTES = ["position", "normal", "value"]; // at these places in all programs

function program(gl, vertex, fragment) {
  const made = gl.createProgram(), places = new Map();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  ATTRIBUTES.forEach((name, place) => gl.bindAttribLocation(made, place, name));
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  const at = (name) => {
    if (!places.has(name)) places.set(name, gl.getUniformLocation(made, name));
    return places.get(name);
  };
  return { program: made, at };
}

/** The colour at 0 .. 1 among colours that are evenly spread. */
function between(colors, at) {
  const place = Math.min(Math.max(at, 0), 1) * (colors.length - 1), first = Math.min(Math.floor(place), colors.length - 2);
  if (colors.length === 1) return colors[0];
  return colors[first].map((value, k) => value + (place - first) * (colors[first + 1][k] - value));
}
