// sequence(frames, options): what of a sequence of scans stays and what moves, and how: docs/use/sequence.md.
//
// One frame is the reference: its points are the model. A first reading of all frames finds the two parts
// (part_finder.hpp), a second one fits both parts to every frame and checks that the frame shows the part that stays
// (static_check.hpp). At any time there are two frames and the model in memory, and some thinned points of eight
// frames.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "isopach/apps/jaw.hpp"
#include "isopach/apps/motions.hpp"
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/compare/comparison.hpp"

namespace isopach {

struct SequenceOptions {
  std::size_t reference = 0;         ///< which frame, counted from 0: angles and ways are relative to it
  std::size_t model_points = 12000;  ///< of the reference that parts are found and fitted by, about
  double least_part = 0.02;          ///< share of the model that the moving part has at least
  std::optional<Point3> static_at;   ///< the part nearest to this place stays; default: the one that moves less
  std::optional<Point3> follow;      ///< point of the moving part to follow; default: the farthest from the hinge axis
  double smooth = 2;                 ///< frames to either side that a path is smoothed over; 0: not
  double rate = 0;                   ///< frames a second; 0: unknown, times are frame numbers
  std::string unit;                  ///< of lengths; empty: as in the reference
};

/// The frames, read one at a time.
struct FrameSource {
  std::size_t count = 0;
  std::function<std::string(std::size_t)> name;
  std::function<Cloud(std::size_t)> read;  ///< throws InputError for a frame that cannot be read
};

/// One frame. Poses and points are in coordinates of the reference frame unless said otherwise.
struct FrameMotion {
  std::size_t index = 0;
  std::string name;
  std::string skipped;  ///< why; empty: used
  double time = 0;      ///< seconds, or the frame's number
  std::size_t points = 0;
  Pose head;                                      ///< T_frame_reference of the part that stays
  Pose motion;                                    ///< of the part that moves, relative to the part that stays
  Pose local;                                     ///< the same between the parts' own frames (T_static_moving)
  double rms_static = 0, rms_moving = 0;          ///< distances of the parts' points to the frame's surface
  double support_static = 0, support_moving = 0;  ///< share of the part's points that lie on it
  double sigma_angle = 0, sigma_shift = 0;        ///< of `motion`: rad, and length at the middle of the part
  double opening = 0;                             ///< rad about the hinge axis; without one the whole angle
  double angle = 0;                               ///< rad, whole
  std::optional<Screw> screw;                     ///< where it turns by 1 degree or more
  Point3 chin{0, 0, 0}, chin_smooth{0, 0, 0};     ///< the point that is followed
  Point3 hinge{0, 0, 0}, hinge_smooth{0, 0, 0};   ///< the hinge point, carried along
  double opening_smooth = 0;                      ///< rad
  double excursion = 0;                           ///< how far the chin is from its place in the reference
  Point3 excursion_local{0, 0, 0};                ///< the same along the axes of the static frame: aside, up, forward
};

enum class PartLabel : unsigned char { still = 0, moving = 1, between = 2 };

struct SequenceResult {
  SequenceOptions options;
  InputSummary reference;
  std::string unit = "unknown";
  std::vector<FrameMotion> frames;  ///< all of them, in order
  std::size_t used = 0;
  Array<Point3> points;    ///< of the reference, input coordinates, finite ones
  Array<Index> ids;        ///< of these in the reference's file
  Array<double> blend;     ///< of each: 0 stays, 1 moves
  Array<PartLabel> label;  ///< of each: by the blend; between: from 0.15 to 0.85
  std::size_t points_static = 0, points_moving = 0, points_between = 0;
  std::optional<HingeAxis> hinge;
  Pose static_frame, moving_frame;  ///< T_reference_local: origins the hinge point and the chin, axes alike
  Point3 chin{0, 0, 0};             ///< the point that is followed, in the reference
  double widest = 0;                ///< largest opening, rad
  double farthest = 0;              ///< largest excursion
  std::vector<std::string> warnings;
  Timing timing;
};

/// A frame that cannot be read, is empty or does not show the model is reported (FrameMotion::skipped, a warning) and
/// skipped. Errors: UsageError for fewer than 2 frames or options without sense; InputError where the reference cannot
/// be used, where no part moves against the rest, and where fewer than 2 frames are left; Error with exit code 5 where
/// the frames are of another object than the reference (static_check.hpp). Cost: each frame is read twice, four times
/// where frames of something else had a say in the parts; O(points log points) a frame. The same bits for any number of
/// threads and any order of the points.
[[nodiscard]] SequenceResult sequence(const FrameSource& frames, const SequenceOptions& options,
                                      const Context& context);

}  // namespace isopach
