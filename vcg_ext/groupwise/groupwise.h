// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Groupwise optimisation of correspondence: the maps of a population are moved along their
/// surfaces until one model of shape explains all of them together.
///
/// Propagation hands one map to shape after shape, and what each step loses stays lost. Here no
/// shape is the root: each gets a diffeomorphism phi_k of the sphere, and its landmarks lie where
/// phi_k takes the vertices of an icosphere. By turns a Gaussian model of the population's
/// deformations is learnt from what the surfaces show (population_model.h), and the landmarks flow
/// along their surfaces to where it expects them (sphere_fields.h, moving_landmarks.h); what all
/// have in common says nothing, and is taken out. The maps that result are phi_k^-1 after the maps
/// that came.
///
/// For comparison there is the description length of R. H. Davies et al., A minimum description
/// length approach to statistical shape modeling, 2002, as H. H. Thodberg, Minimum description
/// length shape and appearance models, 2003, and T. Heimann et al., 3D active shape models using
/// gradient descent optimization of description length, 2005, minimise it, with area weights
/// (description_length.h). It lowers its own cost, not reliably the error: see docs/groupwise.md.

#include <cmath>
#include <vector>

#include "vcg_ext/anchors/anchor_set.h"
#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/model/procrustes.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

enum class GroupwiseObjective {
  PopulationModel,
  DescriptionLength,
};

struct GroupwiseParameters {
  GroupwiseObjective objective = GroupwiseObjective::PopulationModel;
  Alignment alignment = Alignment::Rigid;
  int iterations = 8;           ///< 1 to 1000
  double surfacePrecision = 0;  ///< that of the surfaces over that of the prior; 0: 1000
  double priorShapes = 2;       ///< for how many shapes the prior counts, above 0
  int frequency = 7;            ///< of the icosphere of landmarks, 3 to 30
  /// Points that correspond (population_anchors.h), one set per shape, or none at all; of
  /// PopulationModel. Names that one shape alone has say nothing.
  std::vector<AnchorSet> anchors = {};
  /// Standard deviation of an anchor per coordinate, in the shapes' unit; 0: the mean edge length
  /// of its surface.
  double anchorDeviation = 0;
};

/// The fewest shapes that have anything in common.
constexpr int minGroupwiseShapes = 2;

struct GroupwiseShape {
  MappedSurface map;
  double tangentialMove = 0;  ///< mean distance between landmarks before and after, by area, once
                              ///< the map is opened
  double modelResidual = 0;   ///< root mean square of the distance, along the normal, between
                              ///< landmarks and where the model expects them
  int repairedFaces = 0;      ///< faces that were flipped before the repair
  double followedShare = 1;   ///< of the flows that the map could follow
  double trust = 1;           ///< how much it counted for what all have in common, 0 to 1: little
                              ///< where its shape does not belong to the others
  double squeezed = 0;        ///< share of its surface that had too little of the sphere on the map
                              ///< that came, and was opened first (opened_maps.h)
  double anchorDistance = std::nan("");  ///< mean distance of its anchors from the places that the
                                         ///< shapes agree on; NaN: it has none that others have
};

struct Groupwise {
  std::vector<GroupwiseShape> shapes;
  std::vector<double> moves;  ///< of each iteration: how far landmarks still were, along the
                              ///< surface, from where they are expected (root mean square, averaged
                              ///< over the shapes); of DescriptionLength: how far they moved
  std::vector<double> costs;  ///< of DescriptionLength: the cost before each iteration and at the
                              ///< end; else empty
  double varianceBefore = 0;  ///< total variance of the aligned landmarks, by area (divisor K)
  double varianceAfter = 0;   ///< the same in the end
  double surfacePrecision = 0;  ///< that was used; 0 with DescriptionLength
};

/// Throws ParameterError where a parameter is out of range.
void requireValid(const GroupwiseParameters& parameters);

/// surfaces: maps that correspond roughly, as propagation makes them, in one unit; pool: who does
/// the work, with the same result whatever the number of threads. All lengths that come out are in
/// the surfaces' unit. Throws ParameterError where there are fewer than minGroupwiseShapes or a
/// parameter is out of range.
Groupwise optimiseGroupwise(const std::vector<MappedSurface>& surfaces, ThreadPool& pool,
                            const GroupwiseParameters& parameters = {},
                            const Progress& progress = {});

}  // namespace sphere_propagation
