#include "isopach/apps/static_check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "isopach/apps/motions.hpp"
#include "isopach/base/median.hpp"

namespace isopach {
namespace {

constexpr std::size_t most_kept = 8;

double agreement_in(const PoseEvidence& e) { return e.has_detail() ? e.least() : e.agree; }

}  // namespace

StaticCheck::StaticCheck(Cloud part, std::size_t frames, const Context& context)
    : context_(context),
      stride_((frames + most_kept - 1) / most_kept),
      part_(std::move(part)),
      tree_(part_.points),
      judged_(judged_scan(part_, {}, context)) {}

bool StaticCheck::shows(const CloudView& frame, std::size_t k, const Pose& head, std::string& reason) {
  if (!judged_.usable()) return true;
  JudgedScan whole = judged_scan(frame, {}, context_);
  const PoseEvidence evidence = judge(judged_, whole, head).evidence;
  const double agreement = agreement_in(evidence);
  if (!(agreement >= least_agreement)) {
    reason = fmt::format(
        "{:.1f} % of the part that stays agrees with it within noise, in shape by {:.2f}, and {:.0f} % and {:.2f} are "
        "needed: another object, or the part is covered or changed; leave it out",
        100 * std::clamp(evidence.agree, 0.0, 1.0), evidence.shape, 100 * least_agreement, least_agreement);
    return false;
  }
  if (k % stride_ != 0) return true;
  Cloud shown;
  const Pose back = inverted(head);
  for (const Point3& p : frame.points)
    if (tree_.nearest_distance2(back.apply(p)) < judged_.spacing * judged_.spacing) shown.points.push_back(p);
  kept_.push_back({judged_scan(shown, {}, context_), std::move(whole), head, agreement});
  return true;
}

std::string StaticCheck::strangers() const {
  std::vector<double> among, with_reference;
  const std::size_t apart = kept_.size() / 2;  // frames in a row are alike by the slightest of changes
  for (std::size_t i = 0; i + apart < kept_.size() && apart > 0; ++i) {
    const Kept &a = kept_[i], &b = kept_[i + apart];
    if (a.part.usable())
      among.push_back(agreement_in(judge(a.part, b.frame, composed(b.head, inverted(a.head))).evidence));
  }
  for (const Kept& k : kept_) with_reference.push_back(k.with_reference);
  if (among.empty()) return "";
  const double others = median(among), reference = median(with_reference);
  if (others - reference <= rival_margin) return "";
  return fmt::format(
      "where nothing should move the other frames agree with one another (by {:.2f}) better than with the reference "
      "(by {:.2f}; {:.2f} less is taken)",
      others, reference, rival_margin);
}

}  // namespace isopach
