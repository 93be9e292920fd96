// SPDX-License-Identifier: GPL-3.0-only
#include "tests/core/label_shapes.h"

#include "vcg_ext/volume/gaussian_smoothing.h"

namespace sphere_propagation::test {

LabelGrid randomBlobs(unsigned seed, const Eigen::Vector3i& size, double smoothness, double share) {
  Random random(seed);
  ScalarGrid noise(size, Vector3::Zero(), Vector3::Ones());
  for (float& x : noise.values) x = static_cast<float>(random.normal());
  smoothGaussian(noise, smoothness);
  LabelGrid grid = labelsOf([](const Vector3&) { return false; }, size);
  for (int k = 1; k < size[2] - 1; ++k)
    for (int j = 1; j < size[1] - 1; ++j)
      for (int i = 1; i < size[0] - 1; ++i)
        grid.values[grid.index(i, j, k)] = (noise(i, j, k) > 0) != (random.uniform() < share);
  return grid;
}

}  // namespace sphere_propagation::test
