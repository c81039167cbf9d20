// Metro's figures: mean and rms over the area of one surface of the distance to another, by sampling, with what the
// sampling may be off.
//
// Source: [Cignoni1998]. Metro's samples lie on a pattern, and a pattern has no error to tell: over a triangle that
// crosses the other surface the distance is a ridge roof, and its values at the centroids of parts are low on average,
// whatever their number. Here they are random in equal parts (stratified), so the mean is right on average, and two
// independent ones in each part tell how far it may be off ([Cochran1977], 5.6).
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/distance/surface_tree.hpp"

namespace isopach {

struct SurfaceFigures {
  double area = 0;
  std::size_t samples = 0;
  double mean = 0, rms = 0, max = 0;     ///< max of the samples; see Hausdorff for the true one
  double mean_error = 0, rms_error = 0;  ///< standard errors of the sampling
};

struct SurfaceSampling {
  std::size_t per_face = 10;     ///< at least so many samples a face, on average
  std::size_t least = 20'000;    ///< at least so many in all: from few parts the error cannot be told
  double error = 1e-3;           ///< more are taken until the standard errors are this share of mean and rms
  double rounding = 0;           ///< … or this length
  std::size_t most = 4'000'000;  ///< … or there would be more than this
};

/// Distance from the surface `mesh` to the closest point of `other`. Each face is cut into k² equal parts, k² by its
/// area. In each part lie two sets of three samples: a random place and the two that have its barycentric coordinates
/// in turn. Their mean is the centroid, so what is linear over a face comes out exactly, with an error of 0. Places are
/// a function of the face's number: the same bits for any number of threads. Zeros for a surface without area. Cost: a
/// closest point a sample. Oracle: closed forms, tests/distance/surface_figures_test.cpp.
[[nodiscard]] SurfaceFigures surface_figures(const Mesh& mesh, const SurfaceTree& other,
                                             const SurfaceSampling& sampling, const Context& context);

}  // namespace isopach
