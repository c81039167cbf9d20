#include "cli/other_scenes.hpp"

#include <fmt/core.h>

#include <cmath>

#include "isopach/simulate/chewing.hpp"
#include "isopach/simulate/face_and_jaw.hpp"
#include "isopach/simulate/scanned_object.hpp"

namespace isopach::cli {
namespace {

nlohmann::ordered_json rows(const Pose& pose) {
  auto all = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < 16; i += 4) all.push_back({pose.m[i], pose.m[i + 1], pose.m[i + 2], pose.m[i + 3]});
  return all;
}

/// Both scenes have scans that are made alike.
void refuse_pairs(const SceneRequest& request) {
  const auto refuse = [&](bool given, const char* option) {
    if (given)
      throw UsageError(fmt::format("{}: the scene {} has no second scan of one surface", option, request.name));
  };
  refuse(request.points_b.has_value(), "--points-b");
  refuse(request.noise_b.has_value(), "--noise-b");
}

nlohmann::ordered_json scanner_json(const ObjectScanner& s) {
  return {{"points", s.points}, {"noise", s.noise}, {"bias", s.bias},
          {"spot", s.spot},     {"reach", s.reach}, {"scale", s.scale}};
}

constexpr std::size_t reference_points = 60000;

}  // namespace

SceneTruth simulate_chewing(const SceneRequest& request, std::size_t frames, const TakeScan& take,
                            const Context& context) {
  refuse_pairs(request);
  if (!request.variant.empty()) throw UsageError("--variant: the scene chewing has no variants");
  ChewingOptions o;
  if (frames > 0) o.frames = frames;
  if (request.points) o.points = *request.points;
  if (request.noise) o.noise = *request.noise;
  const Chewing chewing(o, request.seed);
  nlohmann::ordered_json truth;
  truth["schema"] = "isopach.truth.chewing/1";
  truth["scene"] = "chewing";
  truth["description"] =
      "a chewing face: head moves the upper part (T_frame_rest), jaw the lower one relative to it, in the coordinates "
      "of "
      "frame 0; the attribute blend of each frame is 0 above, 1 below, between them in the transition zone";
  truth["parameters"] = {{"frames", o.frames},
                         {"points", o.points},
                         {"noise", o.noise},
                         {"opening_deg", o.opening},
                         {"frames_a_cycle", o.frames_a_cycle},
                         {"seed", request.seed}};
  truth["unit"] = "mm";
  truth["hinge"] = {Chewing::hinge.x, Chewing::hinge.y, Chewing::hinge.z};
  truth["frames"] = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < o.frames; ++k) {
    context.step("simulate", static_cast<double>(k) / static_cast<double>(o.frames));
    take(fmt::format("frame_{:03d}", k), chewing.frame(k));
    truth["frames"].push_back({{"head", rows(chewing.head(k))}, {"jaw", rows(chewing.jaw(k))}});
  }
  return {std::move(truth), fmt::format("chewing: {} frames of about {} points", o.frames, o.points)};
}

SceneTruth simulate_combine(const SceneRequest& request, const TakeScan& take) {
  refuse_pairs(request);
  FaceAndJawOptions o;
  if (!request.variant.empty() && request.variant != "held" && request.variant != "forgotten")
    throw UsageError(
        fmt::format("unknown variant '{}' of scene combine: choose one of held, forgotten", request.variant));
  o.held = request.variant != "forgotten";
  if (request.points) o.points = *request.points;
  if (request.noise) o.noise = *request.noise;
  const FaceAndJaw scene = make_face_and_jaw(o, request.seed);
  nlohmann::ordered_json truth;
  truth["schema"] = "isopach.truth.combine/1";
  truth["scene"] = "combine";
  truth["description"] = "a face and a jaw with one reference object before both, and the object alone";
  truth["parameters"] = {
      {"points", o.points}, {"noise", o.noise}, {"variant", o.held ? "held" : "forgotten"}, {"seed", request.seed}};
  truth["unit"] = "mm";
  truth["face_reference"] = rows(scene.face_reference);
  truth["jaw_reference"] = rows(scene.jaw_reference);
  truth["face_jaw"] = rows(scene.face_jaw);
  truth["face_share"] = scene.face_share;
  truth["jaw_share"] = scene.jaw_share;
  take("face", scene.face);
  take("jaw", scene.jaw);
  take("reference", scene.reference);
  return {std::move(truth), fmt::format("combine: face {} points, jaw {}, reference {}", scene.face.points.size(),
                                        scene.jaw.points.size(), scene.reference.points.size())};
}

SceneTruth simulate_accuracy(const SceneRequest& request, const TakeScan& take) {
  const bool scaled = request.variant == "scaled";
  if (!request.variant.empty() && !scaled && request.variant != "in-place")
    throw UsageError(
        fmt::format("unknown variant '{}' of scene accuracy: choose one of in-place, scaled", request.variant));
  ObjectScanner made, reference;
  made.noise = 0.05, made.reach = 0.9;
  if (scaled) made.scale = 1.004, made.moved = true;
  if (!scaled) made.bias = 0.2;
  reference.points = reference_points;
  if (request.points) made.points = *request.points;
  if (request.noise) made.noise = *request.noise;
  if (request.points_b) reference.points = *request.points_b;
  if (request.noise_b) reference.noise = *request.noise_b;
  nlohmann::ordered_json truth;
  truth["schema"] = "isopach.truth.accuracy/1";
  truth["scene"] = "accuracy";
  truth["description"] = "a reconstruction of an object with known errors, and a reference";
  truth["parameters"] = {{"variant", scaled ? "scaled" : "in-place"},
                         {"reconstruction", scanner_json(made)},
                         {"reference", scanner_json(reference)},
                         {"seed", request.seed}};
  truth["unit"] = "mm";
  truth["reference_reconstruction"] = rows(object_pose(made));
  truth["scale"] = 1 / made.scale;
  truth["bias"] = made.bias;
  truth["noise"] = made.noise;
  truth["completeness"] = made.reach;
  take("reconstruction", scan_object(made, request.seed, 0));
  take("reference", scan_object(reference, request.seed, 2));
  return {std::move(truth),
          fmt::format("accuracy: reconstruction {} points, reference {}", made.points, reference.points)};
}

SceneTruth simulate_scanners(const SceneRequest& request, const TakeScan& take) {
  if (!request.variant.empty()) throw UsageError("--variant: the scene scanners has no variants");
  ObjectScanner a, b, reference;
  a.noise = 0.05;
  b.points = 1000, b.noise = 0.1, b.bias = 0.2;
  reference.points = reference_points;
  if (request.points) a.points = *request.points;
  if (request.points_b) b.points = *request.points_b;
  if (request.noise) a.noise = *request.noise;
  if (request.noise_b) b.noise = *request.noise_b;
  // As wide as its points are apart: the disc has the area that a point stands for.
  b.spot = 2 * std::sqrt(object_width * object_depth / (std::acos(-1.0) * static_cast<double>(b.points)));
  nlohmann::ordered_json truth;
  truth["schema"] = "isopach.truth.scanners/1";
  truth["scene"] = "scanners";
  truth["description"] =
      "two scanners of known errors on one object with a texture, and a reference; b averages over a spot";
  truth["parameters"] = {{"seed", request.seed}};
  truth["unit"] = "mm";
  truth["scanners"] = {scanner_json(a), scanner_json(b)};
  truth["reference"] = scanner_json(reference);
  truth["texture"] = {{"wavelengths", {6, 7.75}}, {"rms", 0.1}};
  take("a", scan_object(a, request.seed, 0));
  take("b", scan_object(b, request.seed, 1));
  take("reference", scan_object(reference, request.seed, 2));
  return {std::move(truth),
          fmt::format("scanners: a {} points, b {}, reference {}", a.points, b.points, reference.points)};
}

}  // namespace isopach::cli
