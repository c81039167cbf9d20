// A face and a jaw, scanned apart, with one reference object seen in both, and a scan of the object alone. mm.
//
// The object is a plate of 80 by 44 with a few hills that no motion takes onto one another. It is held before the mouth
// of a face (the lower part of the scene `face`) and beside the cast of a jaw; what lies behind it is hidden. Each scan
// lies in coordinates of its own, turned any way; noise is along the view of its scanner.
// Tests: tests/simulate/face_and_jaw_test.cpp
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/geom/rigid.hpp"

namespace isopach {

struct FaceAndJawOptions {
  std::size_t points = 40000;  ///< of face and jaw each, the object's points included; the object alone has a fourth
  double noise = 0.05;         ///< standard deviation along the view, mm
  bool held = true;            ///< false: the object was forgotten, face and jaw are scanned without it
};

struct FaceAndJaw {
  Cloud face, jaw, reference;
  Pose face_reference, jaw_reference;    ///< T_face_reference, T_jaw_reference
  Pose face_jaw;                         ///< T_face_jaw
  double face_share = 0, jaw_share = 0;  ///< of the scan's points, that lie on the object
};

/// A function of (options, seed); the same bits for any number of threads. Cost O(points). Errors: UsageError for fewer
/// than 1000 points or a noise that is negative or not finite.
[[nodiscard]] FaceAndJaw make_face_and_jaw(const FaceAndJawOptions& options, std::uint64_t seed);

}  // namespace isopach
