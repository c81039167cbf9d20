#include "isopach/geom/trapezoids.hpp"

#include <algorithm>
#include <set>

#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

bool before(const Edge& s, const Edge& t) {
  return s.a == t.a ? lexicographic_less(s.b, t.b) : lexicographic_less(s.a, t.a);
}

// From left to right, without those that are vertical (walls stand there anyway) and without pairs that cancel.
std::vector<Edge> tidied(std::vector<Edge> edges) {
  std::erase_if(edges, [](const Edge& e) { return e.a.x == e.b.x; });
  for (Edge& e : edges)
    if (e.a.x > e.b.x) std::swap(e.a, e.b);
  std::sort(edges.begin(), edges.end(), before);
  std::vector<Edge> result;
  for (const Edge& e : edges) {
    if (!result.empty() && result.back().a == e.a && result.back().b == e.b)
      result.pop_back();
    else
      result.push_back(e);
  }
  return result;
}

class Sweep {
 public:
  explicit Sweep(std::vector<Edge> edges) : edges_(std::move(edges)), status_(Below{edges_}) {
    place_.resize(edges_.size());
    open_.resize(edges_.size());
    inside_above_.resize(edges_.size());
    inserted_at_.resize(edges_.size());
    by_end_.resize(edges_.size());
    for (std::size_t i = 0; i < edges_.size(); ++i) by_end_[i] = i;
    std::sort(by_end_.begin(), by_end_.end(), [&](std::size_t i, std::size_t j) {
      return edges_[i].b.x != edges_[j].b.x ? edges_[i].b.x < edges_[j].b.x : i < j;
    });
  }

  bool run() {
    std::size_t start = 0, end = 0;
    while (end < by_end_.size()) {
      x_ = edges_[by_end_[end]].b.x;
      if (start < edges_.size()) x_ = std::min(x_, edges_[start].a.x);
      ++event_;
      touched_.clear();
      fresh_.clear();
      for (; end < by_end_.size() && edges_[by_end_[end]].b.x == x_; ++end)
        if (!remove(by_end_[end])) return false;
      for (; start < edges_.size() && edges_[start].a.x == x_; ++start)
        if (!insert(start)) return false;
      if (!settle()) return false;
    }
    return true;
  }

  [[nodiscard]] std::vector<Trapezoid>& found() { return found_; }
  [[nodiscard]] Point2 trouble() const { return trouble_; }

 private:
  // Order of two edges that some vertical line meets, along it. Edges that do not cross have one order on all lines.
  struct Below {
    const std::vector<Edge>& edges;
    bool operator()(std::size_t i, std::size_t j) const {
      if (i == j) return false;
      const Edge &s = edges[i], &t = edges[j];
      if (s.a.x <= t.a.x) {
        int side = orientation(s.a, s.b, t.a);
        if (side == 0) side = orientation(s.a, s.b, t.b);
        return side != 0 ? side > 0 : i < j;
      }
      int side = orientation(t.a, t.b, s.a);
      if (side == 0) side = orientation(t.a, t.b, s.b);
      return side != 0 ? side < 0 : i < j;
    }
  };
  using Status = std::set<std::size_t, Below>;
  static constexpr std::size_t none = static_cast<std::size_t>(-1);

  struct Open {
    std::size_t upper = none;
    double x0 = 0;
  };

  bool fail(const Point2& at) {
    trouble_ = at;
    return false;
  }

  // Two neighbours: do they cross, or run on one another?
  [[nodiscard]] bool clash(std::size_t i, std::size_t j) const {
    const Edge &s = edges_[i], &t = edges_[j];
    const int ta = orientation(s.a, s.b, t.a), tb = orientation(s.a, s.b, t.b);
    if (ta == 0 && tb == 0) return std::max(s.a.x, t.a.x) < std::min(s.b.x, t.b.x);
    return ta * tb < 0 && orientation(t.a, t.b, s.a) * orientation(t.a, t.b, s.b) < 0;
  }

  [[nodiscard]] std::size_t below(std::size_t i) const {
    return place_[i] == status_.begin() ? none : *std::prev(place_[i]);
  }
  [[nodiscard]] std::size_t above(std::size_t i) const {
    const auto next = std::next(place_[i]);
    return next == status_.end() ? none : *next;
  }

  void close(std::size_t lower) {
    Open& o = open_[lower];
    if (o.upper != none && o.x0 < x_) found_.push_back({o.x0, x_, edges_[lower], edges_[o.upper]});
    o.upper = none;
  }

  bool remove(std::size_t i) {
    const std::size_t low = below(i), high = above(i);
    close(i);
    status_.erase(place_[i]);
    place_[i] = status_.end();
    inserted_at_[i] = gone;
    if (low != none) touched_.push_back(low);
    if (high != none) touched_.push_back(high);
    return low == none || high == none || !clash(low, high) || fail(edges_[i].b);
  }

  bool insert(std::size_t i) {
    place_[i] = status_.insert(i).first;
    inserted_at_[i] = event_;
    fresh_.push_back(i);
    const std::size_t low = below(i), high = above(i);
    if (low != none) touched_.push_back(low);
    if (high != none) touched_.push_back(high);
    if ((low != none && clash(low, i)) || (high != none && clash(i, high))) return fail(edges_[i].a);
    return true;
  }

  // After all changes at one x: what is inside above the new edges, and which trapezoids end and begin. What is inside
  // above an edge holds for its whole length, so new edges between old ones must not turn it round.
  bool settle() {
    std::sort(fresh_.begin(), fresh_.end(), Below{edges_});
    for (const std::size_t i : fresh_) {
      const std::size_t low = below(i);
      inside_above_[i] = low == none || !inside_above_[low];
    }
    touched_.insert(touched_.end(), fresh_.begin(), fresh_.end());
    for (const std::size_t i : touched_) {
      if (inserted_at_[i] == gone) continue;
      const std::size_t low = below(i), high = above(i);
      const bool inside_below = low != none && inside_above_[low];
      if (inside_below == inside_above_[i] || (high == none && inside_above_[i])) return fail({x_, edges_[i].a.y});
      if (!inside_above_[i] || open_[i].upper == high) continue;
      close(i);
      open_[i] = {high, x_};
    }
    return true;
  }

  static constexpr std::size_t gone = static_cast<std::size_t>(-1);
  std::vector<Edge> edges_;  // by left end
  std::vector<std::size_t> by_end_;
  Status status_;
  std::vector<Status::iterator> place_;
  std::vector<Open> open_;  // by its lower edge
  std::vector<bool> inside_above_;
  std::vector<std::size_t> inserted_at_;
  std::vector<std::size_t> touched_, fresh_;
  std::size_t event_ = 0;
  double x_ = 0;
  std::vector<Trapezoid> found_;
  Point2 trouble_{0, 0};
};

}  // namespace

double height_at(const Edge& edge, double x) {
  if (x <= edge.a.x) return edge.a.y;
  if (x >= edge.b.x) return edge.b.y;
  const double share = (x - edge.a.x) / (edge.b.x - edge.a.x);
  const double y = edge.a.y + share * (edge.b.y - edge.a.y);
  return std::clamp(y, std::min(edge.a.y, edge.b.y), std::max(edge.a.y, edge.b.y));
}

double area_of(const Trapezoid& t) {
  const double left = height_at(t.upper, t.x0) - height_at(t.lower, t.x0);
  const double right = height_at(t.upper, t.x1) - height_at(t.lower, t.x1);
  return (t.x1 - t.x0) * (left + right) / 2;
}

std::optional<std::vector<Trapezoid>> trapezoids(std::vector<Edge> edges, Point2* at) {
  Sweep sweep(tidied(std::move(edges)));
  if (sweep.run()) return std::move(sweep.found());
  if (at != nullptr) *at = sweep.trouble();
  return std::nullopt;
}

}  // namespace isopach
