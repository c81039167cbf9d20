#include "isopach/distance/hausdorff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <queue>

#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t batch =
    2048;  ///< pieces cut in one round: a constant, so that rounds are the same for any threads
constexpr std::size_t piece_block = 64;

struct Corner {
  Point3 p;
  double distance = 0;
  Index face = no_index;  ///< of the other surface, closest to p
};

struct Piece {
  std::array<Corner, 3> corners;
  double upper = 0;
  Index best = no_index;  ///< the face that gives `upper`
  int depth = 0;
};

struct Children {
  std::array<Piece, 3> pieces;
  int count = 0;
  Corner seen;  ///< the farthest point met on the way
};

double largest_coordinate(const Mesh& mesh) {
  return reduce_blocks<double>(
      mesh.points.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        double largest = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const Point3& p = mesh.points[i];
          if (is_finite(p)) largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
        }
        return largest;
      },
      [](double& total, double part) { total = std::max(total, part); });
}

class Search {
 public:
  Search(const SurfaceTree& to, double margin, double rounding) : to_(to), margin_(margin), rounding_(rounding) {}

  [[nodiscard]] Corner corner(const Point3& p) const {
    const Closest c = to_.closest(p);
    return {p, std::sqrt(c.at.distance2), c.face};
  }

  /// Bounds a piece; asks for the face under its middle only if the corners' faces do not settle it. Gives the farthest
  /// point met.
  Corner judge(Piece& piece, double lower) const {
    const auto& c = piece.corners;
    piece.upper = std::numeric_limits<double>::infinity();
    const Index parent = piece.best;
    for (const Index face : {parent, c[0].face, c[1].face, c[2].face}) try_face(piece, face);
    Corner seen = *std::max_element(c.begin(), c.end(), nearer);
    if (piece.upper > std::max(lower, seen.distance) + margin_) {
      const Corner middle = corner((1.0 / 3) * (c[0].p + c[1].p + c[2].p));
      try_face(piece, middle.face);
      if (nearer(seen, middle)) seen = middle;
    }
    return seen;
  }

  [[nodiscard]] Children cut(const Piece& piece, double lower) const {
    Children children;
    if (piece.depth % 2 != 0 || !cut_along_face(piece, children)) halve(piece, children);
    children.seen = piece.corners[0];
    for (int i = 0; i < children.count; ++i) {
      Piece& child = children.pieces[static_cast<std::size_t>(i)];
      child.depth = piece.depth + 1;
      child.best = piece.best;
      const Corner seen = judge(child, lower);
      if (nearer(children.seen, seen)) children.seen = seen;
    }
    return children;
  }

  static bool nearer(const Corner& a, const Corner& b) { return a.distance < b.distance; }

 private:
  void try_face(Piece& piece, Index face) const {
    if (face == no_index) return;
    const auto s = to_.corners(face);
    double largest = 0;
    for (const Corner& c : piece.corners) largest = std::max(largest, closest_on_triangle(c.p, s).distance2);
    const double upper = std::sqrt(largest);
    if (upper < piece.upper) piece.upper = upper, piece.best = face;
  }

  /// Along the side of the best face beyond which the piece reaches farthest; false if it reaches beyond none.
  bool cut_along_face(const Piece& piece, Children& children) const {
    const auto s = to_.corners(piece.best);
    const Point3 n = isopach::cross(s[1] - s[0], s[2] - s[0]);
    std::array<double, 3> heights{};
    double farthest = 4 * rounding_;
    for (std::size_t k = 0; k < 3; ++k) {
      Point3 inward = isopach::cross(n, s[(k + 1) % 3] - s[k]);
      const double size = length(inward);
      if (size == 0) continue;
      std::array<double, 3> h{};
      for (std::size_t i = 0; i < 3; ++i) h[i] = dot(inward, piece.corners[i].p - s[k]) / size;
      const auto [least, most] = std::minmax_element(h.begin(), h.end());
      if (-*least > farthest && *most > 4 * rounding_) farthest = -*least, heights = h;
    }
    if (farthest == 4 * rounding_) return false;
    slice(piece, heights, children);
    return true;
  }

  /// Cuts where `heights`, linear on the piece and of both signs at its corners, is 0.
  void slice(const Piece& piece, const std::array<double, 3>& h, Children& children) const {
    std::size_t lone = 0;  // the corner alone on its side
    for (std::size_t k = 0; k < 3; ++k)
      if ((h[k] > 0) != (h[(k + 1) % 3] > 0) && (h[k] > 0) != (h[(k + 2) % 3] > 0)) lone = k;
    const std::size_t next = (lone + 1) % 3, last = (lone + 2) % 3;
    const Corner &a = piece.corners[lone], &b = piece.corners[next], &c = piece.corners[last];
    const Corner ab = corner(a.p + (h[lone] / (h[lone] - h[next])) * (b.p - a.p));
    const Corner ac = corner(a.p + (h[lone] / (h[lone] - h[last])) * (c.p - a.p));
    children.pieces[0].corners = {a, ab, ac};
    children.pieces[1].corners = {ab, b, c};
    children.pieces[2].corners = {ab, c, ac};
    children.count = 3;
  }

  void halve(const Piece& piece, Children& children) const {
    std::size_t longest = 0;
    double best = -1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double l = squared_length(piece.corners[(k + 1) % 3].p - piece.corners[k].p);
      if (l > best) best = l, longest = k;
    }
    const Corner &a = piece.corners[longest], &b = piece.corners[(longest + 1) % 3],
                 &c = piece.corners[(longest + 2) % 3];
    const Corner middle = corner(0.5 * (a.p + b.p));
    children.pieces[0].corners = {a, middle, c};
    children.pieces[1].corners = {middle, b, c};
    children.count = 2;
  }

  const SurfaceTree& to_;
  double margin_, rounding_;
};

/// The bound so far and the pieces that may still beat it.
class Frontier {
 public:
  Frontier(HausdorffBound& bound, double margin) : bound_(bound), margin_(margin) {}

  void saw(const Corner& c) {
    if (c.distance > bound_.lower) bound_.lower = c.distance, bound_.at = c.p;
  }
  void add(const Piece& piece) {
    ++bound_.pieces;
    if (!open(piece)) {
      settled_ = std::max(settled_, piece.upper);
      return;
    }
    pieces_.push_back(piece);
    std::push_heap(pieces_.begin(), pieces_.end(), less);
  }
  /// The pieces of largest upper bound; empty when all is settled.
  std::vector<Piece> take() {
    std::vector<Piece> taken;
    while (!pieces_.empty() && taken.size() < batch) {
      if (!open(pieces_.front())) {  // and so is every other
        settled_ = std::max(settled_, pieces_.front().upper);
        pieces_.clear();
        break;
      }
      std::pop_heap(pieces_.begin(), pieces_.end(), less);
      taken.push_back(pieces_.back());
      pieces_.pop_back();
    }
    return taken;
  }
  /// The upper bound once nothing is open.
  [[nodiscard]] double upper() const { return std::max(settled_, bound_.lower); }
  /// The same while pieces are open.
  [[nodiscard]] double upper_now() const {
    return pieces_.empty() ? upper() : std::max(upper(), pieces_.front().upper);
  }

 private:
  static bool less(const Piece& a, const Piece& b) { return a.upper < b.upper; }
  [[nodiscard]] bool open(const Piece& piece) const { return piece.upper > bound_.lower + margin_; }

  HausdorffBound& bound_;
  double margin_;
  double settled_ = 0;
  std::vector<Piece> pieces_;
};

/// Closest points of the corners of faces; what no face uses is not of the surface.
Array<Corner> corners_of(const Mesh& mesh, const Search& search) {
  std::vector<unsigned char> used(mesh.points.size(), 0);
  for (const auto& face : mesh.faces)
    for (const Index corner : face) used[corner] = 1;
  Array<Corner> corners(mesh.points.size());
  for_blocks(corners.size(), piece_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) corners[i] = used[i] != 0 ? search.corner(mesh.points[i]) : Corner{};
  });
  return corners;
}

/// Judges the faces of the mesh and keeps those that are open, a slice at a time so that memory stays small.
void start(const Mesh& mesh, const Search& search, Frontier& frontier, const HausdorffBound& bound,
           const Context& context) {
  const Array<Corner> corners = corners_of(mesh, search);
  for (const Corner& c : corners)
    if (c.face != no_index) frontier.saw(c);
  constexpr std::size_t slice = 1 << 16;
  std::vector<Piece> pieces;
  std::vector<Corner> seen;
  for (std::size_t first = 0; first < mesh.faces.size(); first += slice) {
    context.check();
    const std::size_t n = std::min(slice, mesh.faces.size() - first);
    pieces.assign(n, Piece{});
    seen.assign(n, Corner{});
    const double lower = bound.lower;
    for_blocks(n, piece_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto& f = mesh.faces[first + i];
        pieces[i].corners = {corners[f[0]], corners[f[1]], corners[f[2]]};
        seen[i] = search.judge(pieces[i], lower);
      }
    });
    for (const Corner& c : seen) frontier.saw(c);
    for (const Piece& piece : pieces) frontier.add(piece);
  }
}

}  // namespace

double distance_rounding(const Mesh& a, const Mesh& b) {
  return 32 * std::numeric_limits<double>::epsilon() * std::max(largest_coordinate(a), largest_coordinate(b));
}

HausdorffBound directed_hausdorff(const Mesh& from, const SurfaceTree& to, double tolerance, const Context& context,
                                  std::uint64_t most_pieces) {
  const double rounding = distance_rounding(from, to.mesh());
  if (!(tolerance >= 4 * rounding))
    throw UsageError(fmt::format("@tolerance: {:.3g} is below {:.3g}, what rounding leaves of these coordinates",
                                 tolerance, 4 * rounding));
  const double margin = tolerance - 2 * rounding;
  HausdorffBound bound;
  const Search search(to, margin, rounding);
  Frontier frontier(bound, margin);
  start(from, search, frontier, bound, context);
  std::vector<Children> cut;
  for (std::vector<Piece> taken = frontier.take(); !taken.empty(); taken = frontier.take()) {
    context.check();
    if (bound.pieces > most_pieces)
      throw Error(
          ExitCode::not_converged,
          fmt::format("@tolerance: {:.3g} was not reached with {} pieces: the distance is between {:.6g} and "
                      "{:.6g}; ask for a larger tolerance",
                      tolerance, bound.pieces, bound.lower, std::max(frontier.upper_now(), taken.front().upper)));
    cut.assign(taken.size(), Children{});
    const double lower = bound.lower;
    for_blocks(taken.size(), piece_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) cut[i] = search.cut(taken[i], lower);
    });
    for (const Children& c : cut) frontier.saw(c.seen);
    for (const Children& c : cut)
      for (int i = 0; i < c.count; ++i) frontier.add(c.pieces[static_cast<std::size_t>(i)]);
  }
  bound.upper = frontier.upper() + rounding;
  bound.lower = std::max(0.0, bound.lower - rounding);
  return bound;
}

}  // namespace isopach
