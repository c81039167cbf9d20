// The face that scans are compared with to find a face in them: a mean, symmetric one, as a formula.
#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "isopach/geom/vec.hpp"

namespace isopach {

/// x to the left of the person, y up, z to the front; lengths in widths of the face (between the ears, some 150 mm).
/// The origin is the tip of the nose. The normal has length 1.
struct TemplatePoint {
  Point3 point, normal;
};

/// Terms of the large curvature of a face, which other things have, too: 1, y, y², x², x²y, y³.
inline constexpr std::size_t form_terms = 6;
[[nodiscard]] std::array<double, form_terms> form_of_face(const Point3& p);

struct FaceTemplate {
  std::vector<TemplatePoint> points;  ///< some 700, evenly over the area; symmetric in x
  std::vector<double> relief;         ///< z of each without its form (least squares): nose, eyes, lips
  double chin = 0, hairline = 0;      ///< least and largest y
};

/// Height of the mean face over the plane of its nose tip, before the tip is put at the origin. A polynomial with
/// twenty bells, those beside the middle twice. Its coefficients were fitted to the mean of the canonical face of
/// MediaPipe (Apache 2.0), the head scan of Lee Perry-Smith (CC BY 3.0) and the scan james of menpo3d (BSD), each made
/// symmetric: 0.6 % of the width, RMS. See docs/use/asymmetry.md.
[[nodiscard]] double mean_face(double x, double y);

/// Made once. Test: tests/apps/face_template_test.cpp.
[[nodiscard]] const FaceTemplate& face_template();

}  // namespace isopach
