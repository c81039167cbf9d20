// Fuzz target: `isopach roughness` in memory, with its summary and its JSON.
#include "isopach/apps/roughness.hpp"
#include "isopach/report/roughness.hpp"
#include "tests/fuzz/decode.hpp"

namespace {

using namespace isopach;

RoughnessOptions decode_options(fuzz::Input& in) {
  RoughnessOptions options;
  fuzz::decode_scans(in, options.compare);
  options.form = in.choice({FormKind::none, FormKind::plane, FormKind::polynomial, FormKind::reference});
  if (options.form == FormKind::polynomial) options.degree = 1 + static_cast<unsigned>(in.below(10));
  if (in.flag()) options.s_filter = in.length();
  if (in.flag()) options.l_filter = in.length();
  options.filter = in.choice({MeanFilter::gaussian, MeanFilter::robust});
  options.filter_degree = static_cast<unsigned>(in.below(2));
  if (in.flag()) options.margin = in.below(4) == 0 ? 0 : in.length();
  options.interpolation = in.choice({Interpolation::cubic, Interpolation::linear});
  if (in.flag()) options.wrinkles = {in.length(), in.length()};
  options.match = in.below(8) == 7;
  options.accept_doubt = in.flag();
  return options;
}

void check(const Texture& x) {
  const ArealParameters& p = x.parameters;
  fuzz::require_finite("parameters", {p.area, p.mean, p.sa, p.sq, p.sz, p.ssk, p.sku, p.sdr, p.sdq, p.sq_points});
  fuzz::require_finite("texture", {x.area, x.spacing, x.margin, x.form_sq, x.waviness_sq, x.wrinkles.depth});
  for (const Wrinkle& w : x.wrinkles.all)
    fuzz::require_finite("wrinkle", {w.depth, w.mean_depth, w.length, w.width, w.area, w.volume});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::only_errors([&] {
    const RoughnessOptions options = decode_options(in);
    const Cloud scan = fuzz::decode_cloud(in);
    const bool has_after = in.flag(), has_reference = in.flag();
    const Cloud after = has_after ? fuzz::decode_cloud(in) : Cloud{};
    const Cloud reference = has_reference ? fuzz::decode_cloud(in) : Cloud{};
    const auto given = [](bool is, const Cloud& c) { return is ? std::optional<CloudView>(c) : std::nullopt; };
    const Roughness r =
        roughness(scan, given(has_after, after), given(has_reference, reference), options, fuzz::one_thread());
    check(r.scan);
    if (r.after) check(*r.after);
    fuzz::require(!roughness_json(r, {}).empty() && !roughness_text(r).empty(), "there is a report");
  });
  return 0;
}
