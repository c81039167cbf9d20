#include "cli/chewing.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "isopach/io/write.hpp"
#include "isopach/simulate/chewing.hpp"

namespace isopach::cli {
namespace {

nlohmann::ordered_json rows(const Pose& pose) {
  auto all = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < 16; i += 4) all.push_back({pose.m[i], pose.m[i + 1], pose.m[i + 2], pose.m[i + 3]});
  return all;
}

void refuse(bool given, const char* option) {
  if (given) throw UsageError(fmt::format("{}: the scene chewing has frames, all alike, and no variants", option));
}

}  // namespace

int simulate_chewing(const SceneRequest& request, std::size_t frames, const std::string& extension,
                     OutputFolder& folder, Run& run) {
  refuse(request.points_b.has_value(), "--points-b");
  refuse(request.noise_b.has_value(), "--noise-b");
  refuse(!request.variant.empty(), "--variant");
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

}  // namespace isopach::cli
