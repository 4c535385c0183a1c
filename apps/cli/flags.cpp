// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/flags.h"

#include <fmt/format.h>

#include <algorithm>

#include "splatting/train/settings/train_options.h"

namespace vesta::app {

bool TakesOption(const CommandInfo& command, const schema::FieldInfo& option) {
  if (command.command & (kTrain | kConfig)) return true;
  if (!(command.command & (kRefine | kPrune))) return false;
  // refine and prune add no Gaussians and keep the SH degree and rendering; refine also removes none.
  if (option.name.starts_with("pruning.") && command.command != kPrune) return false;
  return !option.name.starts_with("density.") && option.name != "train.sh_degree" &&
         option.name != "train.background" && option.name != "train.eps2d" && option.name != "train.antialias";
}

namespace {

constexpr schema::Choice<Device> kDevices[] = {{Device::kAuto, "auto"}, {Device::kCpu, "cpu"}, {Device::kCuda, "cuda"}};
constexpr schema::Choice<bool> kYesOrNo[] = {{true, "true"}, {false, "false"}};
constexpr schema::Choice<gs::RefineMethod> kMethods[] = {
    {gs::RefineMethod::kViews, "views"}, {gs::RefineMethod::kLm, "lm"}, {gs::RefineMethod::kBoth, "both"}};
constexpr schema::Choice<Align> kAligns[] = {
    {Align::kNone, "none"}, {Align::kPose, "pose"}, {Align::kPoseAndColor, "pose+colour"}};
constexpr schema::Choice<Show> kShows[] = {{Show::kColor, "colour"},
                                           {Show::kDepth, "depth"},
                                           {Show::kMedianDepth, "median_depth"},
                                           {Show::kNormals, "normals"}};
constexpr schema::Choice<SpzVersion> kSpzVersions[] = {{SpzVersion::kUniversal, "2"}, {SpzVersion::kLatest, "4"}};
constexpr schema::Choice<pose_graph::Initialize> kInitializes[] = {{pose_graph::Initialize::kAuto, "auto"},
                                                                   {pose_graph::Initialize::kGiven, "given"},
                                                                   {pose_graph::Initialize::kChordal, "chordal"}};
constexpr schema::Choice<pose_graph::EdgeError> kErrors[] = {{pose_graph::EdgeError::kG2o, "g2o"},
                                                             {pose_graph::EdgeError::kCeres, "ceres"},
                                                             {pose_graph::EdgeError::kIsotropic, "isotropic"}};
static_assert(schema::AreDistinct(kShows) && schema::AreDistinct(kAligns) && schema::AreDistinct(kDevices) &&
              schema::AreDistinct(kMethods));

std::vector<const char*> PresetNames() {
  std::vector<const char*> names;
  for (const gs::Preset& preset : gs::Presets()) names.push_back(preset.name);
  return names;
}

}  // namespace

const std::vector<CommandInfo>& Commands() {
  static const std::vector<CommandInfo> commands = {
      {kReconstruct, "reconstruct", {"PHOTOS"}, "find the cameras of photographs", "SCENE"},
      {kTrain, "train", {"SCENE"}, "train a splat from photographs", "DIR"},
      {kRefine, "refine", {"SPLAT", "SCENE"}, "train an existing splat further", "DIR"},
      {kPrune, "prune", {"SPLAT", "SCENE"}, "remove the least useful Gaussians", "DIR"},
      {kEval, "eval", {"SPLAT", "SCENE"}, "measure the PSNR and SSIM of a splat"},
      {kRender, "render", {"SPLAT", "SCENE"}, "render images or a video", "DIR"},
      {kView, "view", {"SPLAT"}, "show a splat or checkpoint in a browser", nullptr, false, "SCENE"},
      {kConvert, "convert", {"SPLAT"}, "change the format, crop, remove floaters", "FILE"},
      {kDoctor, "doctor", {"SCENE"}, "check a scene, estimate training time"},
      {kReport, "report", {"DIR"}, "write an HTML report of training runs", nullptr, true},
      {kConfig, "config", {}, "print the training options as JSON"},
      {kBundleAdjust, "bundle_adjust", {"FILE"}, "optimise the cameras and points of a BAL file", "FILE"},
      {kPoseGraph, "pose_graph", {"FILE"}, "optimise the poses of a g2o file", "FILE"},
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

const std::vector<FlagRow>& ProgramFlags() {
  using O = Flags;
  using enum FlagGroup;
  constexpr unsigned kRefines = kRefine | kPrune, kTrains = kTrain | kRefines, kOptions = kTrains | kConfig,
                     kViews = kEval | kRender | kView, kSolves = kBundleAdjust | kPoseGraph;
  constexpr schema::Range kCount{0, 1e9};
  static const std::vector<FlagRow> flags = {
      {kInput,
       kTrain,
       {"resume", &O::resume, schema::Words{"DIR"},
        "continue the training whose checkpoint is in this folder, with its SCENE and options unless given; --out is "
        "then by "
        "default this folder"}},
      {kInput,
       kReport,
       {"scene", &O::scene, schema::Words{"SCENE"},
        "folder of the photographs, if they have moved since the training"}},
      {kInput,
       kConvert,
       {"scene", &O::scene, schema::Words{"SCENE"},
        "photographs of SPLAT; --clean then also removes Gaussians that no photograph shows"}},
      {kInput,
       kReconstruct,
       {"frames",
        &O::frames,
        {3, 10000},
        "number of photographs to take from a film; auto: 3 per second, from 40 to 300"}},
      {kInput,
       kViews | kDoctor,
       {"downscale", &O::downscale, {1, 64}, "divide the width and height of the photographs by N"}},
      {kInput,
       kTrains | kViews | kConvert,
       {"images", &O::images, schema::Words{"DIR"},
        "folder of the photographs inside SCENE, such as images_4; cameras are scaled to their size"},
       kTrains | kConvert},
      {kInput,
       kTrains | kViews | kConvert,
       {"allow_missing", &O::allow_missing, "skip photographs that the scene names but whose files are missing"},
       kTrains | kConvert},
      {kInput,
       kTrains | kViews,
       {"test_every",
        &O::test_every,
        {0, 1e6},
        "use every N-th photograph (by name) as a test view; 0: none; auto: the split of a NeRF scene, else every 8th"},
       kTrains},
      {kInput,
       kTrains | kViews,
       {"test_list", &O::test_list, schema::Words{"FILE"},
        "text file with the file names of the test views, one per line; replaces --test_every"},
       kTrains},
      {kInput,
       kRefines | kViews,
       {"background", &O::background, {0, 1}, "background colour; auto: the colour that SPLAT records, else black"}},
      {kInput,
       kRefines | kViews,
       {"eps2d",
        &O::eps2d,
        {splat::kMinEps2d, splat::kMaxEps2d},
        "2D dilation: variance of the low-pass filter of each Gaussian in the image, in pixels^2; auto: the value that "
        "SPLAT records, else 0.3"},
       kRefines | kViews},
      {kInput,
       kRefines | kViews,
       {"antialias", &O::antialias, kYesOrNo,
        "reduce the opacity of Gaussians as the 2D dilation enlarges them; auto: as SPLAT records"},
       kRefines | kViews},

      {kQuality,
       kOptions | kDoctor,
       {"preset", &O::preset, PresetNames(),
        "defaults of all options: three levels of quality, or the settings of the 3DGS-LM paper or of its code"}},
      {kQuality,
       kTrain | kConfig,
       {"fixed_model", &O::fixed_model,
        "keep the initial Gaussians: no densification or pruning, and all SH degrees from the start"},
       kTrain | kConfig},
      {kQuality,
       kPrune,
       {"max_loss",
        &O::max_loss,
        {1e-6, 1e6},
        "remove Gaussians until the training loss has risen by this fraction (0.05: by 5 %), then train the rest; "
        "auto: not used"}},
      {kQuality,
       kPrune,
       {"size_mib",
        &O::size_mib,
        {1e-9, 1e9},
        "remove Gaussians until point_cloud.ply has at most X MiB; auto: not used"}},
      {kQuality,
       kRefines,
       {"method", &O::method, kMethods,
        "optimiser: Adam on one view at a time, Levenberg-Marquardt (LM) on all views, or Adam and then LM; auto: "
        "views, or lm for the "
        "presets paper and paper_code"}},
      {kQuality,
       kSolves,
       {"iterations", &O::iterations, kCount,
        "stop after N Levenberg-Marquardt iterations; auto: 50 (bundle_adjust), 100 (pose_graph), 1000 (--robust)"}},
      {kQuality,
       kBundleAdjust,
       {"pcg_iterations",
        &O::pcg_iterations,
        {1, 1e9},
        "at most N conjugate-gradient iterations in each Levenberg-Marquardt iteration; auto: 500"}},
      {kQuality, kSolves, {"time_limit", &O::time_limit, kCount, "stop after X seconds, with loading; 0: no limit"}},
      {kQuality,
       kSolves,
       {"loss",
        &O::loss,
        {"none", "huber", "soft_l1", "cauchy", "arctan", "tukey"},
        "robust loss of each reprojection error (pose_graph: of each edge), with the name that Ceres uses"}},
      {kQuality,
       kSolves,
       {"loss_scale",
        &O::loss_scale,
        {1e-6, 1e9},
        "error, in pixels (pose_graph: in standard deviations), above which --loss reduces the influence of an "
        "observation"}},
      {kQuality,
       kPoseGraph,
       {"initialize", &O::initialize, kInitializes,
        "start: given: the poses in FILE; chordal: poses from the edges alone; auto: whichever costs less"}},
      {kQuality,
       kPoseGraph,
       {"error", &O::error, kErrors,
        "error of an edge: as g2o or Ceres's example defines it, or with isotropic weights; auto: g2o, or isotropic "
        "with "
        "--certify"}},
      {kQuality,
       kPoseGraph,
       {"certify", &O::certify, "compute a lower bound of the cost over all poses, with --error=isotropic"}},
      {kQuality,
       kPoseGraph,
       {"robust", &O::robust,
        "find and reject wrong loop closures; the output has the others. Trusts edges between consecutive ids"}},

      {kOutput,
       kReconstruct,
       {"out", &O::out, schema::Words{"SCENE"},
        "folder for the scene; created if it does not exist. The same command continues an interrupted run"}},
      {kOutput,
       kTrains | kRender,
       {"out", &O::out, schema::Words{"DIR"}, "folder for the results; created if it does not exist"}},
      {kOutput,
       kConvert,
       {"out", &O::out, schema::Words{"FILE"},
        "output file; its extension selects the format: .ply, .compressed.ply, .spz, .splat, .sog or .glb"}},
      {kOutput,
       kConvert,
       {"spz_version", &O::spz_version, kSpzVersions,
        "version of a .spz; 2 is less precise, for programs that do not read version 4"}},
      {kOutput, kBundleAdjust, {"out", &O::out, schema::Words{"FILE"}, "output file, in the BAL format"}},
      {kOutput, kPoseGraph, {"out", &O::out, schema::Words{"FILE"}, "output file, in the format of g2o"}},
      {kOutput,
       kReport,
       {"out", &O::out, schema::Words{"FILE"},
        "output file, an HTML page; the default for a single DIR is DIR/report.html"}},
      {kOutput,
       kEval | kSolves,
       {"json", &O::json, schema::Words{"FILE"}, "also write the results to this file, as JSON"}},
      {kOutput,
       kEval,
       {"align", &O::align, kAligns,
        "measure the test views a second time, with each camera fitted to the splat; pose+colour: also with the "
        "exposure "
        "fitted on the left half of each image, measured on the right half"}},
      {kOutput,
       kRender,
       {"path", &O::path, schema::Words{"orbit|spiral|photographs|FILE.json"},
        "camera path: once around the scene, a spiral for cameras that face one way, through all photographs, or the "
        "cameras of a file like transforms.json"}},
      {kOutput,
       kRender,
       {"frames",
        &O::frames,
        {1, 100000},
        "images along the path; auto: 180, 10 for each pair of neighbouring photographs, or the cameras of the file"}},
      {kOutput,
       kRender,
       {"size", &O::size, schema::Words{"WxH"},
        "width and height of the path's images, in pixels; images are cropped to another aspect ratio"}},
      {kOutput,
       kRender,
       {"show", &O::show, kShows,
        "what to render; depth: 16-bit images, whose unit is in cameras.json, and coloured previews; median_depth: the "
        "depth at which half of the light is absorbed; normals: x right, y up, z towards the camera, as colours"}},
      {kOutput, kRender, {"truth", &O::truth, "put the photograph to the right of each rendered image"}},
      {kOutput,
       kRender,
       {"film", &O::film, schema::Words{"FILE.mp4"}, "also write the images as a video; needs the program ffmpeg"}},
      {kOutput, kRender, {"fps", &O::fps, {0.1, 1000}, "frames per second of the video; auto: 30"}},
      {kOutput,
       kConvert,
       {"box", &O::box, schema::Words{"X0,Y0,Z0,X1,Y1,Z1"},
        "keep only Gaussians whose centres are inside this box, in the coordinates of SPLAT"}},
      {kOutput,
       kConvert,
       {"clean", &O::clean,
        "remove floaters: Gaussians that are too faint to see, that enclose the scene, or that have no neighbours"}},
      {kOutput,
       kTrain,
       {"checkpoint_every", &O::checkpoint_every, schema::Words{"N|MINUTESm"},
        "save the state for --resume every N Adam iterations and after each LM iteration, or every so many minutes "
        "(10m), "
        "and on Ctrl-C; without this flag, never"}},
      {kOutput,
       kTrain,
       {"snapshot_every", &O::snapshot_every, schema::Words{"N|MINUTESm"},
        "write an intermediate splat to DIR/snapshot_*.ply every N Adam iterations and after each LM iteration, or "
        "every "
        "so many minutes (10m); without this flag, never"},
       kTrain},
      {kOutput, kTrains, {"report", &O::report, "do not write DIR/report.html"}, kTrains},

      {kBrowser,
       kTrain,
       {"view", &O::view, schema::Words{"PORT"},
        "serve a page that shows the training, with buttons to pause and stop it; without PORT: on a free port"},
       kTrain,
       kAnyPort},
      {kBrowser, kView, {"port", &O::port, {1, 65535}, "port of the page; auto: the first free port from 7007 on"}},
      {kBrowser,
       kView | kTrain,
       {"bind", &O::bind, schema::Words{"ADDRESS"},
        "network address of this machine that serves the page; 0.0.0.0: all of them, for anyone with the link"},
       kTrain},

      {kResources,
       kTrains | kBundleAdjust | kDoctor,
       {"device", &O::device, kDevices,
        "processor to compute on; auto: the GPU for training and refining, if there is one"}},
      {kResources,
       kReconstruct,
       {"device", &O::device, kDevices, "processor for COLMAP; auto: the GPU, if COLMAP has CUDA and there is one"}},
      {kResources,
       kTrains | kViews | kConvert | kSolves | kReport | kDoctor | kReconstruct,
       {"threads", &O::threads, {0, 1024}, "number of threads; 0: one per core"}},
      {kResources,
       kTrains | kViews | kDoctor,
       {"photographs_mib",
        &O::photographs_mib,
        {1e-3, 1e9},
        "MiB of decoded photographs to keep in memory; the others are decoded when needed; auto: half of the available "
        "memory"},
       kTrains},

      {kOther,
       kOptions,
       {"set", &O::set, schema::Words{"KEY=VALUE"}, "set any other option by its key; may be repeated"}},
      {kOther,
       kOptions,
       {"config", &O::config, schema::Words{"FILE"},
        "read options from a metrics.json or from the output of `vesta config`; they override --preset; other flags "
        "and "
        "--set override them"}},
      {kOther,
       kTrains | kRender | kConvert | kReport | kSolves | kReconstruct,
       {"quiet", &O::quiet, "print only errors"},
       kTrains | kRender | kConvert | kReport | kSolves | kReconstruct},
      {kOther,
       kTrains | kSolves,
       {"log_lm", &O::log_lm, "log each Levenberg-Marquardt iteration, and the solver's report, to stderr"},
       kTrains | kSolves},
      {kOther,
       kTrains | kSolves,
       {"profile", &O::profile, "print the time of each phase at the end; a training run also writes it to its files"},
       kTrains | kSolves},
  };
  return flags;
}

FlagGroup GroupOf(const schema::FieldInfo& option) {
  if (option.name.starts_with("memory.")) return FlagGroup::kResources;
  if (option.name == "train.downscale") return FlagGroup::kInput;
  if (option.name == "train.seed") return FlagGroup::kOther;
  return FlagGroup::kQuality;
}

const char* Heading(FlagGroup group) {
  switch (group) {
    case FlagGroup::kInput:
      return "Input";
    case FlagGroup::kQuality:
      return "Quality and time";
    case FlagGroup::kOutput:
      return "Output";
    case FlagGroup::kBrowser:
      return "Browser page";
    case FlagGroup::kResources:
      return "Resources";
    case FlagGroup::kOther:
      break;
  }
  return "Other";
}

}  // namespace vesta::app
