#pragma once

#include "deja_view/lab/sim/light_source.hpp"
#include "deja_view/lab/sim/scene.hpp"

#include <cstdint>
#include <vector>

namespace deja_view::sim {

/// Bakes the light of `lamps` into a grid of about `spacing` [m] over every surface: lamps with
/// shadows, plus ambient light dimmed in corners (fraction of the hemisphere that is closed
/// within 1.5 m). Fills `scene->light` and the light map fields of the surfaces. Deterministic on
/// any number of threads.
void BakeLight(const std::vector<LightSource>& lamps, double spacing, int threads, Scene* scene);

/// Baked irradiance at (u, v) [m], bilinear; positions beyond the surface are clamped to it.
float SampleLight(const Scene& scene, const Surface& surface, float u, float v);

}  // namespace deja_view::sim
