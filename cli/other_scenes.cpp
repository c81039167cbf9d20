#include "cli/other_scenes.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "isopach/io/write.hpp"
#include "isopach/simulate/chewing.hpp"
#include "isopach/simulate/face_and_jaw.hpp"

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

}  // namespace

int simulate_chewing(const SceneRequest& request, std::size_t frames, const std::string& extension,
                     OutputFolder& folder, Run& run) {
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
    run.context().step("simulate", static_cast<double>(k) / static_cast<double>(o.frames));
    write_cloud(folder.path(fmt::format("frame_{:03d}{}", k, extension)), chewing.frame(k), run.context());
    truth["frames"].push_back({{"head", rows(chewing.head(k))}, {"jaw", rows(chewing.jaw(k))}});
  }
  folder.write_text("truth.json", truth.dump(2) + "\n");
  run.context().check();
  folder.commit();
  run.show(fmt::format("chewing: {} frames of about {} points", o.frames, o.points));
  return 0;
}

int simulate_combine(const SceneRequest& request, const std::string& extension, OutputFolder& folder, Run& run) {
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
  write_cloud(folder.path("face" + extension), scene.face, run.context());
  write_cloud(folder.path("jaw" + extension), scene.jaw, run.context());
  write_cloud(folder.path("reference" + extension), scene.reference, run.context());
  folder.write_text("truth.json", truth.dump(2) + "\n");
  run.context().check();
  folder.commit();
  run.show(fmt::format("combine: face {} points, jaw {}, reference {}", scene.face.points.size(),
                       scene.jaw.points.size(), scene.reference.points.size()));
  return 0;
}

}  // namespace isopach::cli
