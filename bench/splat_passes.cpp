// Time of each splatting pass and of the loss on one view: bench/splat_passes SCENE PLY [--view=N] [--repeats=N]
// [--threads=N] [--json FILE].
#include <fmt/format.h>

#include "bench/report.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/io/load_scene.h"
#include "problems/gaussian_splatting/train/adam.h"
#include "problems/gaussian_splatting/train/metrics.h"

namespace vesta::bench {
namespace {

void Run(const Arguments& arguments) {
  if (arguments.positional.size() != 2)
    Fail("usage: splat_passes SCENE PLY [--view=N --repeats=N --threads=N --json FILE]");
  const int repeats = std::stoi(arguments.Flag("repeats", "15"));
  SetNumThreads(std::stoi(arguments.Flag("threads", "0")));
  const gs::Scene scene = gs::LoadScene(arguments.positional[0]);
  const gs::SplatModel splats = gs::ReadSplatPly(arguments.positional[1]);
  const std::size_t view_index = std::stoul(arguments.Flag("view", "1"));
  if (view_index >= scene.views.size()) Fail("--view={}: the scene has {} views", view_index, scene.views.size());

  const splat::Model<float> model = gs::ToKernelModel(splats);
  const auto pinhole = gs::ToPinhole(scene.views[view_index], gs::NearPlane(scene));
  const ImageShape shape{pinhole.width, pinhole.height};
  const HostSpan<const float> truth(scene.views[view_index].image.rgb.data(), shape.NumValues());
  const double background[3] = {splats.background[0], splats.background[1], splats.background[2]};
  splat::View<float> view;
  splat::ViewWorkspace<float> workspace;
  HostBuffer<float> image(shape.NumValues()), d_image(shape.NumValues()), weighted(shape.NumValues());
  HostBuffer<float> dx(static_cast<Index>(splats.data.size())), gradient(dx.size());
  HostBuffer<float> blocks(66 * model.count), sh_diagonal(dx.size() - splat::kSh * model.count);
  CounterRandom random(1, 0);
  for (float& value : dx) value = static_cast<float>(random.Uniform() - 0.5);
  PhotometricLoss<float> loss;
  PhotometricLinearization<float> linearization;

  Report report("splat_passes");
  double forward = 0;
  const auto add = [&](const char* pass, const auto& body) {
    const double ms = MedianMilliseconds(repeats, body);
    if (std::string(pass) == "forward") forward = ms;
    report.Add({{"pass", std::string(pass)},
                {"ms", ms},
                {"of forward", forward > 0 ? ms / forward : 0.0},
                {"ns per pair and row", 1e6 * ms / (static_cast<double>(view.num_pairs()) * splat::kTileSize)},
                {"splats", static_cast<double>(view.num_splats())},
                {"pairs", static_cast<double>(view.num_pairs())},
                {"pixels", static_cast<double>(view.num_pixels())}});
  };
  view.Build(model, pinhole, background, workspace);
  const splat::VisitCounts visits = view.CountVisits();
  fmt::print(
      "{} pairs walked of {}, {:.2f} vectors a pair, {:.3f} of them useful, {:.2f} pixels in each, {:.1f} splats a "
      "pixel\n",
      visits.pairs, view.num_pairs(), static_cast<double>(visits.vectors) / visits.pairs,
      static_cast<double>(visits.useful) / visits.vectors, static_cast<double>(visits.pixels) / visits.useful,
      static_cast<double>(visits.pixels) / view.num_pixels());
  add("forward", [&] { view.Render(image.data()); });
  add("build (project, sort, bin)", [&] { view.Build(model, pinhole, background, workspace); });
  add("tangent J v", [&] { view.ApplyJ(model, dx.data(), d_image.data(), workspace); });
  add("loss gradient and W", [&] { loss.Linearize(image, truth, shape, d_image, linearization); });
  add("loss W v", [&] { loss.ApplyW(linearization, d_image, weighted); });
  add("adjoint J^T u", [&] { view.AddJT(model, image.data(), d_image.data(), gradient.data(), workspace); });
  add("Gram blocks", [&] {
    view.AddGram(model, image.data(), linearization.diagonal.data(), blocks.data(), sh_diagonal.data(), workspace);
  });
  // One iteration of Adam as training has it: one view at full size, every Gaussian it sees updated.
  gs::SplatModel trained = splats;
  gs::Adam adam(gs::LearningRates(), scene.extent);
  PhotometricLoss<float> adam_loss({.l1_floor = 0});
  std::size_t next = 0;
  const auto iteration = [&] {
    const gs::View& target = scene.views[next++ % scene.views.size()];
    const splat::Model<float> x = gs::ToKernelModel(trained);
    view.Build(x, gs::ToPinhole(target, gs::NearPlane(scene)), background, workspace);
    view.Render(image.data());
    adam_loss.Gradient(image, HostSpan<const float>(target.image.rgb.data(), shape.NumValues()), shape, d_image);
    view.AddJT(x, image.data(), d_image.data(), gradient.data(), workspace);
    adam.Step(trained, gradient.data(), splat::NumAttributes(x.active_sh_degree), 1e-3);
  };
  add("loss gradient", [&] { adam_loss.Gradient(image, truth, shape, d_image); });
  add("Adam step", [&] { adam.Step(trained, gradient.data(), splat::NumAttributes(model.active_sh_degree), 1e-3); });
  add("Adam iteration, all views in turn", iteration);
  report.Finish(arguments.Flag("json", ""));
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  try {
    vesta::bench::Run({argc, argv, {"view", "repeats", "threads", "json"}});
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "splat_passes: {}\n", error.what());
    return 1;
  }
}
