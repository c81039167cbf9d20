// Scenes of `simulate` that are not two scans of one surface: chewing (a sequence of frames), combine (a face, a jaw
// and the reference object in both), accuracy and scanners (scans of one object with known errors, and a reference).
#pragma once
#include <string>

#include "cli/output.hpp"
#include "cli/scene.hpp"

namespace isopach::cli {

/// Writes frame_000, frame_001, … and truth.json to `folder` and commits it. `frames` 0: the scene's own number.
int simulate_chewing(const SceneRequest& request, std::size_t frames, const std::string& extension,
                     OutputFolder& folder, Run& run);

/// Writes face, jaw, reference and truth.json to `folder` and commits it.
int simulate_combine(const SceneRequest& request, const std::string& extension, OutputFolder& folder, Run& run);

/// Writes reconstruction, reference and truth.json to `folder` and commits it.
int simulate_accuracy(const SceneRequest& request, const std::string& extension, OutputFolder& folder, Run& run);

/// Writes a, b, reference and truth.json to `folder` and commits it.
int simulate_scanners(const SceneRequest& request, const std::string& extension, OutputFolder& folder, Run& run);

}  // namespace isopach::cli
