// Fuzz target: `isopach compare` in memory, with its summary and its JSON.
#include "isopach/compare/compare.hpp"
#include "isopach/compare/displacement.hpp"
#include "isopach/report/page/text.hpp"
#include "isopach/report/report.hpp"
#include "tests/fuzz/decode.hpp"

namespace {

using namespace isopach;

void check(const Measures& m) {
  const DifferenceStatistics& d = m.difference;
  fuzz::require_finite("volumes", {m.area, m.rho, m.volume.above, m.volume.below, m.volume.net, m.volume.absolute});
  fuzz::require_finite("differences", {d.mean, d.rms, d.std, d.median, d.nmad, d.max_above, d.max_below});
  for (const double p : d.abs_percentiles) fuzz::require_finite("percentile", {p});
  for (const Percentile& p : d.more_percentiles) fuzz::require_finite("percentile", {p.value});
  fuzz::require(m.area >= 0 && m.volume.above >= 0 && m.volume.below >= 0, "areas and parts are 0 or more");
}

void check(const Comparison& c) {
  check(c.measures);
  if (c.overlay) fuzz::require_finite("overlay", {c.overlay->rho, c.overlay->volume.net});
  fuzz::require_finite("areas", {c.domain_area, c.area_union, c.coverage, c.trimmed_area, c.sliver_area});
  if (c.detail) fuzz::require_finite("detail", {c.detail->rho});
  if (c.weighted) fuzz::require_finite("weighted", {c.weighted->integral, c.weighted->net, c.weighted->rho});
  if (c.currents) fuzz::require_finite("currents", {c.currents->distance(), c.currents->relative()});
  if (c.noise_floor) fuzz::require_finite("noise floor", {c.noise_floor->rho, c.noise_floor->debiased_rho});
  for (const BudgetRow& row : c.budget) fuzz::require_finite("budget", {row.area, row.mean, row.rho, row.volume.net});
  const Uncertainty& u = c.uncertainty;
  if (u.sigma) fuzz::require_finite("sigma", {u.sigma->net, u.sigma->above, u.sigma->below});
  if (u.lod) fuzz::require_finite("level of detection", {*u.lod});
  fuzz::require(c.fields_a.dz_signed.size() + c.fields_b.dz_signed.size() > 0, "points have differences");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::only_errors([&] {
    const Cloud a = fuzz::decode_cloud(in);
    const Cloud b = in.below(8) == 7 ? a : fuzz::decode_cloud(in);
    const CompareOptions options = fuzz::decode_comparison(in);
    const Comparison c = compare(a, b, options, fuzz::one_thread());
    check(c);
    (void)plain_displacement(c);
    fuzz::require(!comparison_json(c, {}).empty() && !comparison_text(c, std::nullopt).empty(), "there is a report");
  });
  return 0;
}
