// StaticCheck: whether the frames of a sequence show the part that stays, by verdicts on its poses.
//
// A fit to a frame of another object ends somewhere, too, and the parts are drawn by what lies on the frames: what of
// another face happens to suit the reference is then what stays, and fits. The verdict (match/verdict/verdict.hpp)
// counts all that both scans see of the part, by the noise that each of them shows by itself. Noise may hide the
// difference of two faces from it; then the frames still agree with one another better than with the reference.
#pragma once
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/match/verdict/verdict.hpp"

namespace isopach {

class StaticCheck {
 public:
  /// `part`: the points of the reference that stay, on the planes of their neighbours, as those of all frames here;
  /// `frames`: how many there are, the reference included.
  StaticCheck(Cloud part, std::size_t frames, const Context& context);

  /// Whether `frame`, number k, shows the part at `head` (T_frame_reference): the verdict's lesser number, or its
  /// `agree` alone on a surface without detail, is least_agreement or more. False, with the reason, where it is less;
  /// true where the part has too few points for a verdict. Cost: judged_scan(), two or three times.
  [[nodiscard]] bool shows(const CloudView& frame, std::size_t k, const Pose& head, std::string& reason);

  /// Why the frames are of another object than the reference although each of them passed: at their poses they agree
  /// with one another better than with it, by more than rival_margin, medians of both. Empty where they do not, and
  /// where fewer than two frames passed. Looks at eight frames at most, spread over the sequence, which are kept as
  /// judged scans. Test: Sequence.FramesThatAgreeWithOneAnotherButNotWithTheReference in tests/apps/sequence_test.cpp.
  [[nodiscard]] std::string strangers() const;

 private:
  struct Kept {
    JudgedScan part, frame;  ///< the part as this frame shows it; all of the frame
    Pose head;
    double with_reference = 0;
  };

  const Context& context_;
  std::size_t stride_;
  Cloud part_;
  PointTree tree_;
  JudgedScan judged_;
  std::vector<Kept> kept_;
};

}  // namespace isopach
