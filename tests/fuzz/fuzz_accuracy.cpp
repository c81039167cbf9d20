// Fuzz target: `isopach accuracy` and `isopach scanners` in memory, with their summaries and JSON; few iterations.
#include "isopach/apps/accuracy.hpp"
#include "isopach/apps/scanners.hpp"
#include "isopach/report/accuracy.hpp"
#include "isopach/report/scanners.hpp"
#include "tests/fuzz/decode.hpp"

namespace {

using namespace isopach;

void run_accuracy(fuzz::Input& in) {
  AccuracyOptions options;
  options.match = fuzz::decode_matching(in);
  options.match.accept_doubt = in.flag();
  options.align = in.choice({Align::none, Align::none, Align::rigid, Align::scale});
  if (in.flag()) options.within = in.length();
  const Cloud cloud = fuzz::decode_cloud(in);
  const Cloud reference = fuzz::decode_cloud(in);
  const Accuracy a = accuracy(cloud, reference, options, fuzz::one_thread());
  fuzz::require_finite("accuracy", {a.scale, a.comparison.measures.rho, a.normal.rho, a.completeness.share});
  fuzz::require(!accuracy_json(a, {}, {}).empty() && !accuracy_text(a, {}).empty(), "there is a report");
}

void run_scanners(fuzz::Input& in) {
  ScannersOptions options;
  options.match = fuzz::decode_matching(in);
  options.match.accept_doubt = in.flag();
  options.align = in.below(4) == 3;
  if (in.flag()) options.reference_sigma = in.length();
  const Cloud a = fuzz::decode_cloud(in);
  const Cloud b = fuzz::decode_cloud(in);
  const Cloud reference = fuzz::decode_cloud(in);
  const Scanners s = scanners(a, b, reference, options, fuzz::one_thread());
  fuzz::require_finite("scanners", {s.rho, s.bias, s.scan[0].rho, s.scan[1].rho, s.scan[0].coverage});
  fuzz::require(!scanners_json(s, {}).empty() && !scanners_text(s).empty(), "there is a report");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::only_errors([&] { in.flag() ? run_scanners(in) : run_accuracy(in); });
  return 0;
}
