// roughness(scan): how rough a surface is once its form and its waviness are removed, and which wrinkles it has; with a
// second scan also what changed (docs/use/roughness.md).
//
// Order of ISO 25178-2: S-filter (short waves, noise), F-operation (form), L-filter (waviness); the parameters are
// those of what is left, the roughness. Heights are along the direction.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/match/verdict/verdict.hpp"
#include "isopach/measure/texture/areal.hpp"
#include "isopach/measure/texture/wrinkles.hpp"

namespace isopach {

enum class FormKind { none, plane, polynomial, reference };
enum class MeanFilter { gaussian, robust };

struct RoughnessOptions {
  CompareOptions compare;  ///< of the scans: project, pose of the second, border, max_edge, unit, allow_crs,
                           ///< check_layers, folds
  FormKind form = FormKind::plane;
  unsigned degree = 2;                       ///< of FormKind::polynomial
  double s_filter = 0;                       ///< cut-off of the S-filter, unit of x and y; 0: none
  double l_filter = 0;                       ///< cut-off of the L-filter; 0: none
  MeanFilter filter = MeanFilter::gaussian;  ///< what the L-filter removes; wrinkles always use the robust one
  unsigned filter_degree = 1;                ///< see GaussianOptions
  double margin = -1;                        ///< not evaluated: nearer to the rim than this; below 0: half of l_filter
  Interpolation interpolation = Interpolation::cubic;  ///< between the points, for the parameters
  WrinkleOptions wrinkles;
  bool match = false;         ///< move the second scan and the reference onto the first before anything else
  bool accept_doubt = false;  ///< take a matching whose pose is not trusted
};

/// One scan's answer.
struct Texture {
  InputSummary input;
  double area = 0;                           ///< of what the scan supports, without folds unless they are kept
  double folded_area = 0, folded_share = 0;  ///< of folds, and ÷ (area with them), see overlay/folds.hpp
  double spacing = 0;                        ///< √(area ÷ nodes)
  double margin = 0;                         ///< as in force
  std::vector<double>
      form;  ///< coefficients by rising degree of Legendre polynomials in the box of the scan; may be none
  double form_sq = 0, waviness_sq = 0;  ///< root mean square of what was removed, about its mean, over the area
  ArealParameters parameters;
  Wrinkles wrinkles;
  /// z1 the surface, z2 − z1 its roughness, in_domain the evaluated triangles.
  Cells cells;
  Array<double> valley;      ///< at nodes: height over the robust waviness, in which wrinkles are valleys
  Measures relief, valleys;  ///< distributions of the two, for their maps
  std::vector<Attribute>
      fields;  ///< by point: waviness, roughness, valley, wrinkle (its number or 0); NaN: not evaluated
};

struct Roughness {
  RoughnessOptions options;  ///< poses as in force
  Frame frame;
  std::string unit = "unknown";
  Texture scan;
  std::optional<Texture> after;
  std::vector<LineDepth> wrinkles_after;  ///< the first scan's wrinkles, in the second
  std::optional<InputSummary> reference;
  Pose reference_pose;
  std::optional<Verdict> verdict, reference_verdict;  ///< on the poses of the two, if options.match
  std::vector<std::string> warnings;
  Timing timing;
};

/// `after` and `reference` may be missing; the reference is needed by FormKind::reference and by nothing else. Both
/// scans are seen in one frame and treated alike; each has a form of its own, but for a reference. Errors: UsageError
/// for options that contradict one another, for a cut-off below twice the spacing or above 1e60, and where the margin
/// leaves nothing; InputError as choose_frame and project, and where heights have another unit than x and y;
/// OverlapError where the reference lies nowhere under the scan; not converged, where match does not. A function of the
/// set of points, the same bits for any number of threads. Cost: O(n log n) and the filters. Tests:
/// tests/apps/roughness_test.cpp.
[[nodiscard]] Roughness roughness(const CloudView& scan, const std::optional<CloudView>& after,
                                  const std::optional<CloudView>& reference, const RoughnessOptions& options,
                                  const Context& context);

}  // namespace isopach
