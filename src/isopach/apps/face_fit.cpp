#include "isopach/apps/face_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "isopach/apps/face_template.hpp"
#include "isopach/base/linear.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr double profile_radii[] = {0.16, 0.28};
constexpr double tips_apart = 0.10;
constexpr std::size_t most_tips = 14;  // to either side
constexpr double pitches[] = {-.75, -.45, -.15, .15, .45, .75};
constexpr double sizes[] = {1.75, 1.4, 1.1, .85, .65, .45};
constexpr std::size_t first_points = 90, search_points = 160;  // of the template
constexpr std::size_t kept_first = 40, kept_then = 14, tried_first = 400;
constexpr double widths[] = {.08, .06, .05, .04, .03, .03, .03, .025, .025, .025, .025, .025};
constexpr std::size_t sorting_step = 6;

/// The axes of one plane: o in it, e1 and e2 along it, e1 × e2 = n.
struct Section {
  MirrorPlane plane;
  Point3 o{0, 0, 0}, e1{1, 0, 0}, e2{0, 1, 0};
};

Section section_of(const MirrorPlane& plane) {
  Section s;
  s.plane = plane;
  s.o = plane.offset * plane.normal;
  plane_axes(plane.normal, s.e1, s.e2);
  return s;
}

/// Where the template lies in a section.
struct Placing {
  double pitch = 0;  ///< angle of the front from e1
  double hand = 1;   ///< 1, −1: which way is up
  double size = 1;   ///< width of the face
  double a = 0, b = 0;
  double score = 0;
  std::size_t number = 0;
};

/// A placing with its sines taken.
class Placed {
 public:
  Placed(const Section& s, const Placing& at)
      : n_(s.plane.normal),
        front_(std::cos(at.pitch) * s.e1 + std::sin(at.pitch) * s.e2),
        up_(at.hand * (std::cos(at.pitch) * s.e2 - std::sin(at.pitch) * s.e1)),
        tip_(s.o + at.a * s.e1 + at.b * s.e2),
        size_(at.size) {}

  explicit Placed(const FaceFit& fit)
      : n_(fit.plane.normal), front_(fit.front), up_(fit.up), tip_(fit.tip), size_(fit.width) {}

  [[nodiscard]] Point3 direction(const Point3& v) const { return v.x * n_ + v.y * up_ + v.z * front_; }
  [[nodiscard]] Point3 point(const Point3& p) const { return tip_ + size_ * direction(p); }
  [[nodiscard]] double size() const { return size_; }
  [[nodiscard]] const Point3& tip() const { return tip_; }
  [[nodiscard]] const Point3& front() const { return front_; }
  [[nodiscard]] const Point3& up() const { return up_; }

 private:
  Point3 n_, front_, up_, tip_;
  double size_;
};

/// A point of the template and the point of the scan nearest to it.
struct Meeting {
  Point3 place, normal, apart;  ///< of the template; of the scan; place − point of the scan
  double distance = 0, cosine = 0;
  bool near = false;
};

template <class Nearest>
Meeting meet(const Placed& placed, const TemplatePoint& t, const ThinPoints& thin, double gate, Nearest&& nearest) {
  constexpr double least_cosine = 0.75;
  Meeting m;
  m.place = placed.point(t.point);
  const Index j = nearest(m.place);
  m.normal = thin.normals[j];
  m.apart = m.place - thin.points[j];
  m.distance = length(m.apart);
  m.cosine = std::fabs(dot(m.normal, placed.direction(t.normal)));
  m.near = m.distance < gate * placed.size() + thin.spacing && m.cosine > least_cosine;
  return m;
}

/// A fixed choice of the template's points, in a fixed order.
const std::vector<TemplatePoint>& template_choice() {
  static const std::vector<TemplatePoint> chosen = [] {
    const FaceTemplate& face = face_template();
    std::vector<std::size_t> order(face.points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const RandomStream random(2, 1);
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return random.bits(a) < random.bits(b); });
    std::vector<TemplatePoint> points;
    for (std::size_t k = 0; k < std::min(search_points, order.size()); ++k) points.push_back(face.points[order[k]]);
    return points;
  }();
  return chosen;
}

/// What stands out along the profile, to either side: of each point near the plane, how far.
struct Profile {
  std::vector<Index> points;
  std::vector<double> out;
};

Profile profile_of(const ThinPoints& thin, const MirrorPlane& plane) {
  Profile profile;
  std::vector<Index> around;
  for (std::size_t i = 0; i < thin.points.size(); ++i) {
    if (!(std::fabs(plane.distance(thin.points[i])) < 1.3 * thin.spacing)) continue;
    if (!(std::fabs(dot(thin.normals[i], plane.normal)) < 0.5)) continue;
    double out = 0;
    for (const double radius : profile_radii) {
      around.clear();
      thin.tree->within(thin.points[i], radius, around);
      std::sort(around.begin(), around.end());
      Point3 sum{0, 0, 0};
      for (const Index k : around) sum = sum + (thin.points[i] - thin.points[k]);
      out += dot(sum, thin.normals[i]) / (static_cast<double>(around.size()) * radius);
    }
    profile.points.push_back(static_cast<Index>(i));
    profile.out.push_back(out);
  }
  return profile;
}

/// `side`: 1, −1, of the normals, whose sign means nothing.
std::vector<Index> tips_of(const Profile& profile, const ThinPoints& thin, double side) {
  std::vector<std::size_t> order(profile.points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return side * profile.out[a] > side * profile.out[b]; });
  std::vector<Index> kept;
  for (const std::size_t k : order) {
    if (kept.size() == most_tips) break;
    const Point3& p = thin.points[profile.points[k]];
    const auto close = [&](Index other) { return length(thin.points[other] - p) < tips_apart; };
    if (std::none_of(kept.begin(), kept.end(), close)) kept.push_back(profile.points[k]);
  }
  return kept;
}

std::vector<Placing> starts_of(const ThinPoints& thin, const Section& s) {
  const Profile profile = profile_of(thin, s.plane);
  std::vector<Placing> starts;
  if (profile.points.size() < 8) return starts;
  for (const double side : {1.0, -1.0})
    for (const Index tip : tips_of(profile, thin, side)) {
      const Point3 &n = thin.normals[tip], d = thin.points[tip] - s.o;
      const double out = std::atan2(side * dot(n, s.e2), side * dot(n, s.e1));
      for (const double pitch : pitches)
        for (const double hand : {1.0, -1.0})
          for (const double size : sizes)
            starts.push_back({out + pitch, hand, size, dot(d, s.e1), dot(d, s.e2), 0, starts.size()});
    }
  return starts;
}

void best_first(std::vector<Placing>& all) {
  std::sort(all.begin(), all.end(), [](const Placing& a, const Placing& b) {
    return a.score != b.score ? a.score > b.score : a.number < b.number;
  });
}

bool alike(const Placing& a, const Placing& b) {
  constexpr double pitch = .25, size = .2, place = .15;
  const double turn = std::remainder(a.pitch - b.pitch, 2 * std::numbers::pi);
  return std::fabs(turn) <= pitch && a.hand == b.hand && std::fabs(std::log(a.size / b.size)) <= size &&
         std::hypot(a.a - b.a, a.b - b.b) <= place * a.size;
}

std::vector<Placing> first_choice(const ThinPoints& thin, const NearestGrid& grid, const Section& s) {
  constexpr double gate = .14, width = .08;
  std::vector<Placing> all = starts_of(thin, s);
  const std::vector<TemplatePoint>& face = template_choice();
  const std::size_t count = std::min(first_points, face.size());
  for_blocks(all.size(), 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Placing& at = all[i];
      const Placed placed(s, at);
      for (std::size_t k = 0; k < count; ++k) {
        const Meeting m = meet(placed, face[k], thin, gate, [&](const Point3& p) { return grid.near(p); });
        const double q = m.distance / (width * at.size);
        if (m.near) at.score += (m.cosine - .5) / (1 + q * q);
      }
    }
  });
  best_first(all);
  std::vector<Placing> kept;
  for (std::size_t i = 0; i < std::min(all.size(), tried_first) && kept.size() < kept_first; ++i)
    if (std::none_of(kept.begin(), kept.end(), [&](const Placing& other) { return alike(all[i], other); }))
      kept.push_back(all[i]);
  return kept;
}

/// One Gauss–Newton step on pitch, size and two shifts.
void improve(Placing& at, const Section& s, const ThinPoints& thin, const NearestGrid& grid, double gate,
             double width) {
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  const Placed placed(s, at);
  for (const TemplatePoint& t : template_choice()) {
    const Meeting m = meet(placed, t, thin, gate, [&](const Point3& p) { return grid.near(p); });
    if (!m.near) continue;
    const double r = dot(m.normal, m.apart), q = r / (width * at.size), w = 1 / ((1 + q * q) * (1 + q * q));
    const Point3 arm = m.place - placed.tip();
    const Eigen::Vector4d j(dot(m.normal, cross(s.plane.normal, arm)), dot(m.normal, arm), dot(m.normal, s.e1),
                            dot(m.normal, s.e2));
    a += w * j * j.transpose();
    g += w * r * j;
  }
  a += (1e-6 * a.trace() + 1e-12) * Eigen::Matrix4d::Identity();
  const Eigen::Vector4d d = Ldlt(a).solve(-g);
  const double most = .2 * at.size;
  at.pitch += std::clamp(d[0], -.2, .2);
  at.a += std::clamp(d[2], -most, most);
  at.b += std::clamp(d[3], -most, most);
  at.size *= std::exp(std::clamp(d[1], -.15, .15));
}

double near_score(const Placing& at, const Section& s, const ThinPoints& thin, const NearestGrid& grid, double gate) {
  const Placed placed(s, at);
  double score = 0;
  for (const TemplatePoint& t : template_choice()) {
    const Meeting m = meet(placed, t, thin, gate, [&](const Point3& p) { return grid.near(p); });
    const double q = dot(m.normal, m.apart) / (.03 * at.size);
    if (m.near) score += 1 / (1 + q * q);
  }
  return score;
}

/// The scan's relief against the template's: places where both are known.
struct Relief {
  std::vector<std::size_t> places;  ///< of the template
  std::vector<double> scan;         ///< by place of the template: height of the scan there, in widths
};

/// Both without what the large curvature explains.
struct Reduced {
  Eigen::VectorXd scan, face;
};

Reduced reduced(const Relief& relief) {
  const FaceTemplate& face = face_template();
  const auto n = static_cast<Eigen::Index>(relief.places.size());
  Eigen::MatrixXd form(n, static_cast<Eigen::Index>(form_terms));
  Reduced r{Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t k = relief.places[static_cast<std::size_t>(i)];
    const std::array<double, form_terms> terms = form_of_face(face.points[k].point);
    for (Eigen::Index c = 0; c < form.cols(); ++c) form(i, c) = terms[static_cast<std::size_t>(c)];
    r.scan[i] = relief.scan[k];
    r.face[i] = face.relief[k];
  }
  const Ldlt normal(product_of_transposed(form, form));
  for (Eigen::VectorXd* z : {&r.scan, &r.face}) *z -= product(form, normal.solve(product_of_transposed(form, *z)));
  return r;
}

/// Twice the worst eleventh is left out: an open mouth is no reason to doubt a face.
void describe_relief(Relief relief, FaceFit& fit) {
  constexpr double kept = .91;
  constexpr std::size_t enough = 60;
  Reduced r = reduced(relief);
  for (int round = 0; round < 2 && relief.places.size() >= enough; ++round) {
    std::vector<double> bad(relief.places.size());
    for (std::size_t i = 0; i < bad.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      bad[i] = std::fabs(r.scan[k] - r.face[k]);
    }
    std::vector<double> sorted = bad;
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(kept * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), at, sorted.end());
    std::vector<std::size_t> rest;
    for (std::size_t i = 0; i < bad.size(); ++i)
      if (bad[i] <= *at) rest.push_back(relief.places[i]);
    relief.places = std::move(rest);
    r = reduced(relief);
  }
  const Eigen::VectorXd s = r.scan.array() - r.scan.mean(), t = r.face.array() - r.face.mean();
  const double both = std::sqrt(s.squaredNorm() * t.squaredNorm());
  fit.correlation = both > 0 ? s.dot(t) / both : 0;
  fit.slope = r.face.squaredNorm() > 0 ? r.scan.dot(r.face) / r.face.squaredNorm() : 0;
}

double slope_factor(double slope) { return slope > 0 ? std::min(slope, 1 / std::max(slope, .01)) : 0; }

FaceFit placed_fit(const Section& s, const Placing& at) {
  const Placed placed(s, at);
  FaceFit fit;
  fit.front = placed.front(), fit.up = placed.up(), fit.tip = placed.tip();
  fit.width = at.size;
  fit.plane = s.plane;
  if (dot(fit.left(), s.plane.normal) < 0) fit.plane = {-1.0 * s.plane.normal, -s.plane.offset};
  return fit;
}

}  // namespace

Point3 FaceFit::left() const { return cross(up, front); }

double FaceFit::likeness() const {
  return covered > 0 ? good / covered * std::max(correlation, 0.0) * slope_factor(slope) : 0;
}

Point3 FaceFit::in_widths(const Point3& p) const {
  const Point3 d = p - tip;
  return {plane.distance(p) / width, dot(d, up) / width, dot(d, front) / width};
}

std::vector<FaceFit> fit_face(const ThinPoints& points, const NearestGrid& grid, const MirrorPlane& plane) {
  const Section s = section_of(plane);
  std::vector<Placing> kept = first_choice(points, grid, s);
  constexpr std::size_t wide_steps = 5;
  for (std::size_t k = 0; k < std::size(widths); ++k) {
    if (k == sorting_step) {
      for (Placing& at : kept) at.score = near_score(at, s, points, grid, .10);
      best_first(kept);
      kept.resize(std::min(kept.size(), kept_then));
    }
    for_blocks(kept.size(), 2, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        improve(kept[i], s, points, grid, k < wide_steps ? .15 : .10, widths[k]);
    });
  }
  std::vector<FaceFit> all(kept.size());
  for_blocks(kept.size(), 2, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) all[i] = judged(placed_fit(s, kept[i]), points);
  });
  std::erase_if(all, [](const FaceFit& f) { return !(f.rank > 0); });
  std::stable_sort(all.begin(), all.end(), [](const FaceFit& a, const FaceFit& b) { return a.rank > b.rank; });
  return all;
}

FaceFit judged(FaceFit fit, const ThinPoints& thin) {
  constexpr double gate = .12, deepest = .15, follows = .08, least_cosine = .85, flat = .35, least_covered = .3;
  const FaceTemplate& face = face_template();
  const Placed placed(fit);
  Relief relief;
  relief.scan.resize(face.points.size());
  double good = 0;
  for (std::size_t k = 0; k < face.points.size(); ++k) {
    const Meeting m =
        meet(placed, face.points[k], thin, gate, [&](const Point3& p) { return thin.tree->nearest_two(p).first; });
    const double along = dot(m.normal, fit.front);
    const double slant = std::fabs(along) < flat ? std::copysign(flat, along) : along;
    const double over = -dot(m.normal, m.apart) / (slant * fit.width);  // of the scan over the template, in widths
    if (!(m.distance < gate * fit.width + thin.spacing && std::fabs(over) < deepest)) continue;
    relief.places.push_back(k);
    relief.scan[k] = face.relief[k] + over;
    good += m.cosine > least_cosine && std::fabs(over) < follows ? 1 : 0;
  }
  const auto count = static_cast<double>(face.points.size());
  fit.covered = static_cast<double>(relief.places.size()) / count;
  fit.good = good / count;
  fit.correlation = fit.slope = fit.rank = 0;
  if (fit.covered < least_covered) return fit;
  describe_relief(std::move(relief), fit);
  fit.rank = fit.good * std::max(fit.correlation, 0.0) * std::min(1.5 * slope_factor(fit.slope), 1.0);
  return fit;
}

FaceFit settled(FaceFit fit, const ThinPoints& points) {
  constexpr int most_steps = 40;
  constexpr double gate = .1, least_cosine = .8, narrowest = .012, tukey = 3.5, most = .05, still = 1e-6;
  const FaceTemplate& face = face_template();
  const Point3 left = fit.left();
  struct Row {
    Eigen::Vector4d j;
    double r;
  };
  for (int step = 0; step < most_steps; ++step) {
    std::vector<Row> rows(face.points.size());
    std::vector<unsigned char> near(face.points.size());
    for_blocks(face.points.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const auto turned = [&](const Point3& v) { return v.x * left + v.y * fit.up + v.z * fit.front; };
        const Point3 arm = fit.width * turned(face.points[k].point), place = fit.tip + arm;
        const PointTree::Two two = points.tree->nearest_two(place);
        const Point3& m = points.normals[two.first];
        near[k] = two.first2 < gate * gate * fit.width * fit.width &&
                  std::fabs(dot(m, turned(face.points[k].normal))) > least_cosine;
        rows[k] = {Eigen::Vector4d(dot(m, cross(left, arm)), dot(m, arm), dot(m, fit.up), dot(m, fit.front)),
                   dot(m, place - points.points[two.first])};
      }
    });
    std::vector<double> misfits;
    for (std::size_t k = 0; k < rows.size(); ++k)
      if (near[k] != 0) misfits.push_back(std::fabs(rows[k].r));
    if (misfits.size() < 12) return fit;
    const double reach = tukey * std::max(mad_to_sigma * median(misfits), narrowest * fit.width);
    Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double q = rows[k].r / reach;
      if (near[k] == 0 || !(q * q < 1)) continue;
      const double w = (1 - q * q) * (1 - q * q);
      a += w * rows[k].j * rows[k].j.transpose();
      g += w * rows[k].r * rows[k].j;
    }
    a += 1e-12 * a.trace() * Eigen::Matrix4d::Identity();
    const Eigen::Vector4d d = Ldlt(a).solve(-g);
    const double turn = std::clamp(d[0], -most, most), shift = most * fit.width;
    const Point3 up = std::cos(turn) * fit.up + std::sin(turn) * cross(left, fit.up);
    fit.front = std::cos(turn) * fit.front + std::sin(turn) * cross(left, fit.front);
    fit.up = up;
    fit.tip = fit.tip + std::clamp(d[2], -shift, shift) * fit.up + std::clamp(d[3], -shift, shift) * fit.front;
    fit.width *= std::exp(std::clamp(d[1], -most, most));
    if (std::fabs(turn) < still) break;
  }
  return fit;
}

}  // namespace isopach
