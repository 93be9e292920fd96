// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Surfaces that are mirror images of the others, a left bone among right ones, and what makes them
/// alike: what groomers of shape models call to reflect (J. Cates, S. Elhabian and R. Whitaker,
/// ShapeWorks: particle-based shape correspondence and visualization software, 2017).

#include <optional>
#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/sequence/propagation_order.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

/// The surface reflected across the plane x = plane: (x, y, z) goes to (2 plane - x, y, z). Corners
/// 1 and 2 of each face are exchanged, so that it looks outward as before; numbers of vertices and
/// faces stay.
ClosedSurface mirrorImage(const ClosedSurface& surface, double plane = 0);

struct SurfaceSide {
  bool mirrored = false;  ///< certainly the mirror image of the root's kind
  bool known = false;     ///< whether it is certain, either way
  bool inDoubt = false;  ///< one of those that are certainly not all on one side, but which of them
                         ///< are mirrored is not known
  int imageOf = -1;      ///< the surface whose mirror image it is exactly, and not its copy; the
                         ///< higher number of the two has it
  int against = 0;       ///< where it is doubtful: of so many compared surfaces the image is nearer
  int compared = 0;
  bool isDoubtful() const { return against > 0; }
};

struct SurfaceSides {
  std::vector<SurfaceSide> surfaces;
  std::optional<double> noSide;  ///< where they have no side in common, so that nobody could tell a
                                 ///< mirror image: the median margin (below)
};

/// Which side each surface is on, for the sequence as a whole; the root tells which side is right.
///
/// Of a pair of surfaces the evidence is ln(m / s), s and m being how far the one lies off the
/// other at best as it is, and as its mirror image (chirality.h): at most 1 either way, nothing
/// where it is below 0.05, the less the worse both fit (half at 0.05 R, none beyond 0.25 R). The
/// sides s_i = +-1 maximise
///   sum over pairs of evidence s_i s_j + 0.15 |sum s_i| - (0.3 where sum s_i < 0),
/// since most surfaces are on one side, on the root's rather than on the other; a surface's side is
/// certain where every choice of sides with the other one is worse by at least 0.5. Pairs are the
/// arcs of the tree, and of surfaces whose side is not certain those with the surfaces whose axes
/// are the most alike, up to six. So a shape that is nearly its own mirror image, as skulls are,
/// stays, and so do all where mirrored surfaces are about as many as others that the root tells
/// nothing about.
///
/// That is all for phases of one subject, known by their shape, which changes little from one to
/// the next. Of different subjects pairs do not err independently of each other: each has an
/// asymmetry of its own, and where these have nothing in common, about half of the subjects look
/// mirrored, seen from any of them. So all are compared once more, each with the six that are the
/// most alike, and a surface's margin is ln(nearest image / nearest surface), everything on the
/// side that was found for it: it is about 0 where the shape has no side. Some are mirrored only
/// where the median margin is as large as 0.1 and the part of the surfaces on the side of the fewer
/// (at least 0.2, at most 0.5 is asked for), and only those with a margin of 0.08 of their own; of
/// surfaces with a margin of 0.5 the side is then known, also where the pairs left it open. With a
/// smaller median nothing is known.
///
/// A doubt is left where at most one of twelve surfaces is on the other side than the rest in the
/// best choice of sides without the preference, and nearer to the images of three of four that it
/// was compared with. Had the surfaces no side in common, all choices would be as likely to be the
/// best, and so few on one side would come about in one of 150 sets of twelve, in fewer of larger
/// ones; of less than twelve it would be no evidence.
///
/// Two surfaces of which one is the mirror image of the other to 0.003 R, while they differ by more
/// than four times that (and than 0.001 R) otherwise, are images of each other, whatever else there
/// is.
///
/// sequence: of one size (surface_sizes.h); tree: one entry per surface.
SurfaceSides findSides(const Sequence& sequence, const PropagationTree& tree, ThreadPool& pool);

/// The sides that this evidence speaks for: #surfaces by #surfaces, symmetric, positive where two
/// are alike. fixed: the surface that is on the right side.
std::vector<SurfaceSide> sidesFromEvidence(const Eigen::MatrixXd& evidence, int fixed);

struct ReflectedSequence {
  Sequence sequence;                          ///< with the mirrored surfaces reflected
  std::vector<std::optional<double>> planes;  ///< across which each was; nothing: it was not
  PropagationTree tree;                       ///< of the order, for the sequence as it is now
  SurfaceSides sides;                         ///< as they were found
};

/// Finds the sides of the surfaces (as large as the others: surface_sizes.h). Reflected are, where
/// `reflects` says so, those that are certainly mirrored, each across the plane x = ... through its
/// centroid (of its area). Where the order goes by shape, the tree is made again for what they are
/// then.
ReflectedSequence reflectMirrorImages(const Sequence& sequence, const PropagationOrder& order,
                                      int root, ThreadPool& pool, bool reflects = true);

}  // namespace sphere_propagation
