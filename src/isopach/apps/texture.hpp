// texture: one scan of a roughness run, stage by stage. Internal to apps/roughness.cpp.
#pragma once
#include "isopach/apps/roughness.hpp"
#include "isopach/match/surface/surface.hpp"

namespace isopach {

/// The surface that is the form, in the frame of the run.
[[nodiscard]] MatchSurface reference_surface(const CloudView& reference, const Pose& pose, const Frame& frame,
                                             const RoughnessOptions& options, const Context& context);

/// `reference` may be null. Warnings are added to those of the run.
[[nodiscard]] Texture texture(const CloudView& cloud, const char* role, const Pose& pose, const Frame& frame,
                              const MatchSurface* reference, const RoughnessOptions& options,
                              std::vector<std::string>& warnings, const Context& context);

/// Depths of the wrinkles of one scan in the valleys of another.
[[nodiscard]] std::vector<LineDepth> follow_wrinkles(const Texture& of, const Texture& in, const Context& context);

}  // namespace isopach
