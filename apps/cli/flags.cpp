// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/flags.h"

#include <fmt/format.h>

#include <algorithm>

#include "splatting/train/settings/train_options.h"

namespace vesta::app {

bool TakesOption(const CommandInfo& command, const schema::FieldInfo& option) {
  if (command.command & (kTrain | kConfig)) return true;
  if (!(command.command & (kRefine | kPrune))) return false;
  // These are the model's, or of growth, of which there is none; who refines takes none out.
  if (option.name.starts_with("pruning.") && command.command != kPrune) return false;
  return !option.name.starts_with("density.") && option.name != "train.sh_degree" &&
         option.name != "train.background" && option.name != "train.eps2d";
}

namespace {

constexpr schema::Choice<Device> kDevices[] = {{Device::kAuto, "auto"}, {Device::kCpu, "cpu"}, {Device::kCuda, "cuda"}};
constexpr schema::Choice<gs::RefineMethod> kMethods[] = {
    {gs::RefineMethod::kViews, "views"}, {gs::RefineMethod::kLm, "lm"}, {gs::RefineMethod::kBoth, "both"}};
constexpr schema::Choice<Align> kAligns[] = {
    {Align::kNone, "none"}, {Align::kPose, "pose"}, {Align::kPoseAndColor, "pose+colour"}};
constexpr schema::Choice<Show> kShows[] = {{Show::kColor, "colour"},
                                           {Show::kDepth, "depth"},
                                           {Show::kMedianDepth, "median_depth"},
                                           {Show::kNormals, "normals"}};
static_assert(schema::EachOnce(kShows) && schema::EachOnce(kAligns) && schema::EachOnce(kDevices) &&
              schema::EachOnce(kMethods));

std::vector<const char*> PresetNames() {
  std::vector<const char*> names;
  for (const gs::Preset& preset : gs::Presets()) names.push_back(preset.name);
  return names;
}

}  // namespace

const std::vector<CommandInfo>& Commands() {
  static const std::vector<CommandInfo> commands = {
      {kTrain, "train", {"SCENE"}, "train a splat from photographs with poses", "DIR"},
      {kRefine, "refine", {"SPLAT", "SCENE"}, "improve a splat of any trainer's", "DIR"},
      {kPrune, "prune", {"SPLAT", "SCENE"}, "take out of a splat what its scene does not need", "DIR"},
      {kEval, "eval", {"SPLAT", "SCENE"}, "measure a splat on the training and test views"},
      {kRender, "render", {"SPLAT", "SCENE"}, "write images of the test views, or along a path, as a film too", "DIR"},
      {kView, "view", {"SPLAT"}, "walk through a splat, or a checkpoint, in the browser", nullptr, false, "SCENE"},
      {kConvert, "convert", {"SPLAT"}, "write a splat in another format, cropped or clean of floaters", "FILE"},
      {kDoctor, "doctor", {"SCENE"}, "say what a scene is, what is odd about it, and what it will take"},
      {kReport, "report", {"DIR"}, "show trainings that are over as one HTML page", nullptr, true},
      {kConfig, "config", {}, "print the options of a training, for --config"},
      {kBundleAdjust, "bundle_adjust", {"FILE"}, "improve cameras and points of a BAL file", "FILE"},
  };
  return commands;
}

const CommandInfo* FindCommand(const std::string& name) {
  const auto& all = Commands();
  const auto found = std::find_if(all.begin(), all.end(), [&](const CommandInfo& c) { return c.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::string UsageForm(const CommandInfo& command) {
  std::string form = fmt::format("vesta {}", command.name);
  for (const char* argument : command.arguments) form += fmt::format(" {}", argument);
  if (command.repeats) form += "...";
  if (command.optional) form += fmt::format(" [{}]", command.optional);
  return command.output ? form + " --out=" + command.output : form;
}

const FlagTable& ProgramFlags() {
  using O = Flags;
  constexpr unsigned kRefines = kRefine | kPrune, kTrains = kTrain | kRefines, kOptions = kTrains | kConfig,
                     kViews = kEval | kRender | kView;
  constexpr schema::Range kCount{0, 1e9};
  static const FlagTable flags = {
      {
          {kTrains | kRender, {"out", &O::out, schema::Words{"DIR"}, "folder for the results, made if missing"}},
          {kConvert,
           {"out", &O::out, schema::Words{"FILE"},
            "file for the result; its extension says the format: .ply, .compressed.ply or .spz"}},
          {kBundleAdjust, {"out", &O::out, schema::Words{"FILE"}, "file for the result"}},
          {kReport,
           {"out", &O::out, schema::Words{"FILE"}, "file for the page; of one DIR, without it: DIR/report.html"}},
          {kReport,
           {"scene", &O::scene, schema::Words{"SCENE"},
            "folder of the photographs, where they are not there any more"}},
          {kEval | kBundleAdjust, {"json", &O::json, schema::Words{"FILE"}, "write the numbers to this file too"}},
          {kRender, {"truth", &O::truth, "put the photograph to the right of each rendered image"}},
          {kRender,
           {"path", &O::path, schema::Words{"orbit|spiral|photographs|FILE.json"},
            "cameras once around, among those that face one way, through all, or as a file in the form of "
            "transforms.json has them"}},
          {kRender,
           {"frames",
            &O::frames,
            {1, 100000},
            "cameras of the path; auto: 180, between photographs 10, those of the file"}},
          {kRender,
           {"size", &O::size, schema::Words{"WxH"},
            "pixels of the path's images; where the shape is another, the middle of what the cameras see"}},
          {kRender, {"film", &O::film, schema::Words{"FILE.mp4"}, "the path as a film too, by the program ffmpeg"}},
          {kRender, {"fps", &O::fps, {0.1, 1000}, "frames a second of the film; auto: 30"}},
          {kRender,
           {"show", &O::show, kShows,
            "depth: images of 16 bits, previews in colours, and what a level is in cameras.json; median_depth: the "
            "same "
            "of where half of the light is gone; normals: x right, y up, z towards the camera as colours"}},
          {kConvert,
           {"box", &O::box, schema::Words{"X0,Y0,Z0,X1,Y1,Z1"},
            "keep the Gaussians whose centres lie within, in the world of SPLAT"}},
          {kConvert,
           {"clean", &O::clean,
            "leave out floaters: what is too faint to be drawn, around everything, or alone, and with --scene what no "
            "photograph shows"}},
          {kConvert, {"scene", &O::scene, schema::Words{"SCENE"}, "the photographs that SPLAT is of, for --clean"}},
          {kOptions | kDoctor,
           {"preset", &O::preset, PresetNames(),
            "where all options start: lengths of ours, or the settings of 3DGS-LM's paper or code"}},
          {kPrune,
           {"max_loss",
            &O::max_loss,
            {1e-6, 1e6},
            "as many go as let the cost of the training views rise by this part of itself, 0.05: by a twentieth, "
            "before "
            "what stays is trained on"}},
          {kPrune, {"size_mib", &O::size_mib, {1e-9, 1e9}, "MiB that point_cloud.ply may have"}},
          {kRefines,
           {"method", &O::method, kMethods,
            "by Adam on single views, Levenberg-Marquardt on all, or one after the other; auto: by views, which gains "
            "more"}},
      },
      {
          {kTrain,
           {"checkpoint_every", &O::checkpoint_every, schema::Words{"N|MINUTESm"},
            "save the state after so many iterations, or minutes (10m); Ctrl-C saves it too"}},
          {kTrain,
           {"resume", &O::resume, schema::Words{"DIR"},
            "go on from the checkpoint in this folder; SCENE and --out may be left out"}},
          {kTrain,
           {"snapshot_every", &O::snapshot_every, schema::Words{"N|MINUTESm"}, "write the splat on the way as often"},
           kTrain},
          {kOptions,
           {"set", &O::set, schema::Words{"KEY=VALUE"}, "any other option, by its key; to be repeated for more"}},
          {kOptions,
           {"config", &O::config, schema::Words{"FILE"},
            "options as in this metrics.json, or what `vesta config` prints; flags win over it"}},
          {kTrains, {"report", &O::report, "leave out DIR/report.html, the result as a page"}, kTrains},
          {kTrain | kConfig,
           {"fixed_model", &O::fixed_model, "the Gaussians that there are from the start, with all SH degrees"},
           kTrain | kConfig},
          {kRefines | kViews,
           {"background", &O::background, {0, 1}, "colour behind everything; auto: the splat's, else black"}},
          {kRefines | kViews,
           {"eps2d",
            &O::eps2d,
            {splat::kMinEps2d, splat::kMaxEps2d},
            "variance of the filter that Gaussians are blurred by, pixels^2; auto: the splat's, else 0.3"},
           kRefines | kViews},
          {kViews | kDoctor, {"downscale", &O::downscale, {1, 64}, "divide the images' width and height by this"}},
          {kTrains | kViews | kConvert,
           {"images", &O::images, schema::Words{"DIR"},
            "folder of the photographs within SCENE, images_4 for one; cameras follow their size"},
           kTrains | kConvert},
          {kTrains | kViews | kConvert,
           {"allow_missing", &O::allow_missing, "leave out photographs that the model names and that are missing"},
           kTrains | kConvert},
          {kTrains | kViews,
           {"test_every",
            &O::test_every,
            {0, 1e6},
            "each of so many photographs by name is for testing, 0: none; auto: every 8th, or as a NeRF scene says"},
           kTrains},
          {kTrains | kViews,
           {"test_list", &O::test_list, schema::Words{"FILE"}, "the photographs for testing, a name in each line"},
           kTrains},
          {kTrains | kViews | kDoctor,
           {"photographs_mib",
            &O::photographs_mib,
            {1e-3, 1e9},
            "MiB of decoded photographs to keep; more than that are decoded when their turn comes; auto: half of the "
            "memory there is"},
           kTrains},
          {kEval,
           {"align", &O::align, kAligns,
            "measure the test views once more with each camera fitted to the splat; with colour, the right half of "
            "each "
            "also with the exposure fitted to the left"}},
          {kBundleAdjust, {"iterations", &O::iterations, kCount, "most iterations of Levenberg-Marquardt"}},
          {kBundleAdjust,
           {"pcg_iterations", &O::pcg_iterations, {1, 1e9}, "most conjugate-gradient iterations in each"}},
          {kBundleAdjust,
           {"time_limit", &O::time_limit, kCount, "stop after so many seconds, loading included; 0: none"}},
          {kBundleAdjust,
           {"loss",
            &O::loss,
            {"none", "huber", "soft_l1", "cauchy", "arctan", "tukey"},
            "robust loss of each reprojection error, by its name in Ceres"}},
          {kBundleAdjust,
           {"loss_scale", &O::loss_scale, {1e-6, 1e9}, "pixels from which an error counts less under --loss"}},
          {kTrain,
           {"view", &O::view, schema::Words{"PORT"},
            "show the training in a browser, where it can be paused and stopped; alone: on a free port"},
           kTrain,
           kAnyPort},
          {kView, {"port", &O::port, {1, 65535}, "port of the page; auto: the first free one from 7007 on"}},
          {kView | kTrain,
           {"bind", &O::bind, schema::Words{"ADDRESS"},
            "address of this machine on which the page is served; 0.0.0.0: all, for whoever has the link"},
           kTrain},
          {kTrains | kBundleAdjust | kDoctor,
           {"device", &O::device, kDevices, "where to compute; auto: train and refine on a GPU where there is one"}},
          {kTrains | kViews | kConvert | kBundleAdjust | kReport | kDoctor,
           {"threads", &O::threads, {0, 1024}, "threads; 0: one for each core"}},
          {kTrains | kRender | kConvert | kReport | kBundleAdjust,
           {"quiet", &O::quiet, "print nothing but errors"},
           kTrains | kRender | kConvert | kReport | kBundleAdjust},
          {kTrains | kBundleAdjust,
           {"log_lm", &O::log_lm, "log each LM iteration, and the engine's report, to stderr"},
           kTrains | kBundleAdjust},
          {kTrains | kBundleAdjust,
           {"profile", &O::profile, "print where the time went, phase by phase; a training writes it to its files too"},
           kTrains | kBundleAdjust},
      }};
  return flags;
}

}  // namespace vesta::app
