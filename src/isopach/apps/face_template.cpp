#include "isopach/apps/face_template.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/linear.hpp"

namespace isopach {
namespace {

/// A hill (or hollow) of the face, in widths of it.
struct Bell {
  double x, y, across, along, z;
  [[nodiscard]] double at(double px, double py) const {
    const double u = (px - x) / across, v = (py - y) / along;
    return z * std::exp(-0.5 * (u * u + v * v));
  }
};

constexpr Bell middle[] = {
    {0, -.012, .051, .077, .1914},   // nose: ridge and tip
    {0, .114, .074, .058, .0977},    // bridge
    {0, -.213, .120, .047, .0328},   // lips
    {0, -.237, .105, .076, .0844},   // mouth region
    {0, -.500, .235, .097, .1316},   // chin
    {0, -.341, .113, .051, .0222},   // below the lip
    {0, .435, .241, .095, .1142},    // forehead
    {0, .206, .047, .055, .0847},    // root of the nose
    {0, -.234, .079, .027, -.0518},  // between the lips
    {0, -.114, .070, .048, -.0419},  // below the nose
};

constexpr Bell sides[] = {
    {.236, .217, .121, .077, -.1563},   // eye socket
    {.227, .222, .076, .061, .1277},    // eyeball
    {.076, -.008, .028, .041, .0791},   // wing of the nose
    {.364, .026, .151, .125, -.0460},   // beside the cheekbone
    {.347, -.344, .090, .096, .0508},   // jaw
    {.143, .328, .089, .050, .0528},    // brow
    {.139, -.253, .047, .027, -.0174},  // corner of the mouth
    {.043, .262, .045, .080, .0364},    // between the brows
    {.068, -.129, .051, .034, .0379},   // beside the nostril
    {.324, .303, .058, .065, .0500},    // outer end of the brow
};

constexpr double half_height = .57;

/// What a face is without its features.
double form(double x, double y) {
  const double u = 4 * x * x, v = y / half_height;
  return -.1888 + v * (-.0474 + v * (-.1868 + v * (.0911 + v * .1111))) + u * (.2294 + v * (.2725 - v * .4814)) +
         u * u * (-1.1403 + v * .0489) + u * u * u * (1.3002 - u * .8216);
}

/// Half the width of the face at this height; 0 outside.
double half_width(double y) {
  const double v = std::fabs(y) / (y > 0 ? .570 : .575);
  return v < 1 ? .497 * std::pow(1 - std::pow(v, y > 0 ? 3.2 : 2.6), 1 / 2.2) : 0;
}

Point3 slope_normal(double x, double y) {
  constexpr double h = 1e-4;
  const double zx = (mean_face(x + h, y) - mean_face(x - h, y)) / (2 * h);
  const double zy = (mean_face(x, y + h) - mean_face(x, y - h)) / (2 * h);
  const double size = std::sqrt(1 + zx * zx + zy * zy);
  return {-zx / size, -zy / size, 1 / size};
}

constexpr double spacing = .0405;  // of the points
constexpr double steepest = .15;   // least z of a normal: what is steeper is seen badly from the front

/// Walks from the middle to the side, a point each time that the way along the surface has grown by the spacing.
void add_row(double y, std::vector<TemplatePoint>& points) {
  constexpr double step = spacing / 200;
  double way = spacing / 2, z = mean_face(0, y);
  for (double x = step; x < half_width(y); x += step) {
    const double next = mean_face(x, y);
    way += std::hypot(step, next - z);
    z = next;
    if (way < spacing) continue;
    way -= spacing;
    const Point3 n = slope_normal(x, y);
    if (n.z < steepest) continue;
    points.push_back({{x, y, z}, n});
    points.push_back({{-x, y, z}, {-n.x, n.y, n.z}});
  }
}

/// The tip of the nose to the origin.
void put_tip_at_origin(std::vector<TemplatePoint>& points) {
  double tip_y = 0;
  for (double y = -.2; y < .2; y += 1e-4)
    if (mean_face(0, y) > mean_face(0, tip_y)) tip_y = y;
  const double tip_z = mean_face(0, tip_y);
  for (TemplatePoint& t : points) t.point.y -= tip_y, t.point.z -= tip_z;
}

std::vector<double> relief_of(const std::vector<TemplatePoint>& points) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd terms(n, static_cast<Eigen::Index>(form_terms));
  Eigen::VectorXd z(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Point3& p = points[static_cast<std::size_t>(i)].point;
    const auto row = form_of_face(p);
    for (Eigen::Index c = 0; c < terms.cols(); ++c) terms(i, c) = row[static_cast<std::size_t>(c)];
    z[i] = p.z;
  }
  const Ldlt normal(product_of_transposed(terms, terms));
  const Eigen::VectorXd rest = z - product(terms, normal.solve(product_of_transposed(terms, z)));
  return {rest.data(), rest.data() + rest.size()};
}

FaceTemplate made() {
  FaceTemplate face;
  for (double y = -.575 + spacing / 2; y < .570; y += spacing * .92) add_row(y, face.points);
  put_tip_at_origin(face.points);
  face.relief = relief_of(face.points);
  for (const TemplatePoint& t : face.points) {
    face.chin = std::min(face.chin, t.point.y);
    face.hairline = std::max(face.hairline, t.point.y);
  }
  return face;
}

}  // namespace

std::array<double, form_terms> form_of_face(const Point3& p) {
  return {1, p.y, p.y * p.y, p.x * p.x, p.x * p.x * p.y, p.y * p.y * p.y};
}

double mean_face(double x, double y) {
  double z = form(x, y);
  for (const Bell& b : middle) z += b.at(x, y);
  for (const Bell& b : sides) z += b.at(x, y) + b.at(-x, y);
  return z;
}

const FaceTemplate& face_template() {
  static const FaceTemplate face = made();
  return face;
}

}  // namespace isopach
