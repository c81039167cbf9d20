// Fuzz target: `isopach match` in memory, with its summary and its JSON; few iterations.
#include "isopach/match/match.hpp"
#include "isopach/report/match.hpp"
#include "tests/fuzz/decode.hpp"

namespace {

using namespace isopach;

void check(const Matching& m, std::size_t points) {
  for (const double entry : m.pose.m) fuzz::require_finite("pose", {entry});
  fuzz::require_finite("search", {m.scale, m.overlap, m.centre.x, m.centre.y, m.centre.z});
  fuzz::require(m.stable.empty() || m.stable.size() == points, "a point is stable or not");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::only_errors([&] {
    const MatchOptions options = fuzz::decode_matching(in);
    const Cloud moving = fuzz::decode_cloud(in);
    const Cloud fixed = fuzz::decode_cloud(in);
    const Matching m = match(moving, fixed, options, fuzz::one_thread());
    check(m, moving.points.size());
    fuzz::require(!match_json(m, {}).empty() && !match_text(m).empty(), "there is a report");
    require_trust(m, "@match");
  });
  return 0;
}
