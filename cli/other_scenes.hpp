// Scenes of `simulate` that are not two scans of one surface: chewing (a sequence of frames), combine (a face, a jaw
// and the reference object in both), accuracy and scanners (scans of one object with known errors, and a reference).
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/command.hpp"
#include "cli/scene.hpp"
#include "isopach/cloud/cloud.hpp"

namespace isopach::cli {

/// Takes a scan of the scene, by the name of its file without an ending.
using TakeScan = std::function<void(const std::string& name, Cloud scan)>;

/// What is true of a scene, as truth.json has it, less its last key, `outputs`; `summary` is a line for people.
struct SceneTruth {
  nlohmann::ordered_json truth;
  std::string summary;
};

/// frame_000, frame_001, … `frames` 0: the scene's own number.
[[nodiscard]] SceneTruth simulate_chewing(const SceneRequest& request, std::size_t frames, const TakeScan& take,
                                          const Context& context);

/// face, jaw, reference.
[[nodiscard]] SceneTruth simulate_combine(const SceneRequest& request, const TakeScan& take);

/// reconstruction, reference.
[[nodiscard]] SceneTruth simulate_accuracy(const SceneRequest& request, const TakeScan& take);

/// a, b, reference.
[[nodiscard]] SceneTruth simulate_scanners(const SceneRequest& request, const TakeScan& take);

}  // namespace isopach::cli
