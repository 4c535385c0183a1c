// SPDX-License-Identifier: Apache-2.0
// Tables of the commands and flags of the program, and the parsed command line. The flags of training options are in
// TrainFields() instead (train_options.h).
#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernels/core/schema.h"
#include "problems/pose_graph/solve.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {

// An invalid command line. what() is one line that says how to correct it.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Bits, so that a set of commands is a sum.
enum Command : unsigned {
  kTrain = 1,
  kRefine = 2,
  kEval = 4,
  kRender = 8,
  kBundleAdjust = 16,
  kConfig = 32,
  kPrune = 64,
  kConvert = 128,
  kReport = 256,
  kDoctor = 512,
  kView = 1024,
  kReconstruct = 2048,
  kPoseGraph = 4096
};

struct CommandInfo {
  Command command;
  const char* name;
  std::vector<const char*> arguments;  // all required
  const char* summary;
  const char* output = nullptr;    // placeholder of the value of --out; null: --out is not required
  bool repeats = false;            // the last argument may be given more than once
  const char* optional = nullptr;  // placeholder of an optional last argument
};
const std::vector<CommandInfo>& Commands();
// Returns the command of this name, or null.
const CommandInfo* FindCommand(const std::string& name);
// The command with its required arguments, for help: "vesta train SCENE --out=DIR".
std::string UsageForm(const CommandInfo& command);

// --align: the parameters that eval fits to each test view before it measures the quality again.
enum class Align { kNone, kPose, kPoseAndColor };

// --show: the quantity that render draws.
enum class Show { kColor, kDepth, kMedianDepth, kNormals };
constexpr bool IsDepth(Show show) { return show == Show::kDepth || show == Show::kMedianDepth; }

// --spz_version: versions of .spz that convert writes.
enum class SpzVersion { kUniversal = 2, kLatest = 4 };

enum class Device { kAuto, kCpu, kCuda };

inline constexpr const char* kDefaultPreset = "balanced";
inline constexpr const char* kAnyPort = "auto";

// The values of the flags of the program. `vesta help COMMAND` explains each.
struct Flags {
  std::string out, json;
  std::string resume;                            // folder of the checkpoint; empty: none
  std::string checkpoint_every, snapshot_every;  // for ParseInterval (checkpointing.h); empty: never
  bool truth = false;
  // render: the camera path and its output (apps/render/shown_views.h).
  std::string path, size, film;  // empty: the test views, the size of the photographs, no video
  std::optional<int> frames;     // empty: depends on the path, or for reconstruct on the film
  std::optional<double> fps;     // frames per second of the video; empty: 30
  Show show = Show::kColor;
  // convert: filters (apps/inputs/splat_filters.h).
  std::string box;
  bool clean = false;
  SpzVersion spz_version = SpzVersion::kLatest;
  bool report = true;                        // write report.html after a training
  std::string scene;                         // empty: for report the folder in metrics.json, for convert none
  std::optional<double> max_loss, size_mib;  // prune: exactly one of these two and --keep is given
  std::optional<gs::RefineMethod> method;    // empty: depends on the preset
  std::string preset;                        // empty: as in --config, or kDefaultPreset
  std::string config;
  std::string set;  // always empty; the values are in CommandLine::options
  bool fixed_model = false;
  std::optional<std::array<double, 3>> background;  // empty: from the splat file
  std::optional<double> eps2d;                      // empty: from the splat file
  std::optional<bool> antialias;                    // empty: from the splat file
  int downscale = 1;
  // Loading of scenes (apps/inputs/scene_and_splat.h).
  std::string images = "images", test_list;
  bool allow_missing = false;
  std::optional<int> test_every;          // empty: as the scene defines, or 8
  std::optional<double> photographs_mib;  // empty: half of the available memory
  Align align = Align::kNone;
  Device device = Device::kAuto;
  int threads = 0;
  std::string view;                // train: port of the page, or "auto"; empty: no page
  std::string bind = "127.0.0.1";  // address on which the viewer listens
  std::optional<int> port;         // empty: the first free port from 7007 on
  bool quiet = false;
  bool log_lm = false;
  bool profile = false;
  // bundle_adjust and pose_graph.
  std::optional<int> iterations, pcg_iterations;  // empty: as in LmOptions
  double time_limit = 0;                          // seconds; 0: none
  std::string loss = "none";
  double loss_scale = 1;
  // pose_graph.
  pose_graph::Initialize initialize = pose_graph::Initialize::kAuto;
  std::optional<pose_graph::EdgeError> error;  // empty: kG2o, or kIsotropic with --certify
  bool certify = false;
  bool robust = false;
};

// The groups of flags, in the order of the help.
enum class FlagGroup { kInput, kQuality, kOutput, kBrowser, kResources, kOther };
const char* Heading(FlagGroup group);
// The group of an option of TrainFields() that has its own flag.
FlagGroup GroupOf(const schema::FieldInfo& option);

struct FlagRow {
  FlagGroup group;
  unsigned commands;  // commands that accept the flag
  schema::Field<Flags> field;
  unsigned rare_for = 0;          // commands whose help lists it only with --all
  const char* if_bare = nullptr;  // value without "=VALUE"; null: a value is required
};
const std::vector<FlagRow>& ProgramFlags();

// A training option given by its own flag or by --set.
struct GivenOption {
  const schema::Field<gs::TrainOptions>* field;
  std::string value;  // valid for the field
};

struct CommandLine {
  const CommandInfo* command = nullptr;  // null: `vesta help`
  std::vector<std::string> arguments;    // positional; for help the topic, if any, and --all
  Flags flags = {};
  std::vector<GivenOption> options = {};  // in the order of the command line; the last value counts
};

// train and config accept all training options. refine and prune reject options that an existing splat determines.
bool TakesOption(const CommandInfo& command, const schema::FieldInfo& option);

}  // namespace vesta::app
