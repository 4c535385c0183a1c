// SPDX-License-Identifier: Apache-2.0
// The tables of commands and flags, and the parsed command line.
#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernels/core/schema.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {

// An invalid command line. what() is one line that says what to do.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

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
  kView = 1024
};

struct CommandInfo {
  Command command;
  const char* name;
  std::vector<const char*> arguments;  // positional, all required
  const char* summary;
  const char* output = nullptr;    // placeholder of --out, if the command requires it
  bool repeats = false;            // the last argument may be given more than once
  const char* optional = nullptr;  // an optional last argument
};
const std::vector<CommandInfo>& Commands();
// Returns null if there is no command of this name.
const CommandInfo* FindCommand(const std::string& name);
// The command with its required arguments and flags: "vesta train SCENE --out=DIR".
std::string UsageForm(const CommandInfo& command);

// The parameters that eval fits to each test view before it measures a second time.
enum class Align { kNone, kPose, kPoseAndColor };

// The quantity that render draws.
enum class Show { kColor, kDepth, kMedianDepth, kNormals };
constexpr bool IsDepth(Show show) { return show == Show::kDepth || show == Show::kMedianDepth; }

enum class Device { kAuto, kCpu, kCuda };

inline constexpr const char* kDefaultPreset = "balanced";
inline constexpr const char* kAnyPort = "auto";

// The values of all flags, with their defaults.
struct Flags {
  std::string out, json;
  std::string resume;                            // folder of the checkpoint; empty: none
  std::string checkpoint_every, snapshot_every;  // as ParseInterval reads them; empty: never
  bool truth = false;
  // render: the camera path and its output (apps/render/shown_views.h).
  std::string path, size, film;  // empty: test views, size of the cameras, no video
  std::optional<int> frames;     // none: depends on the path
  std::optional<double> fps;     // frames per second; none: 30
  Show show = Show::kColor;
  // convert: filters (apps/inputs/splat_filters.h).
  std::string box;
  bool clean = false;
  bool report = true;                        // write report.html after a training
  std::string scene;                         // for report and convert; empty: the scene in metrics.json, or none
  std::optional<double> max_loss, size_mib;  // prune: exactly one of these or --keep
  std::optional<gs::RefineMethod> method;    // none: depends on the preset
  std::string preset;                        // empty: the preset in --config, or kDefaultPreset
  std::string config;
  std::string set;  // always empty: --set fills CommandLine::options
  bool fixed_model = false;
  std::optional<std::array<double, 3>> background;  // none: the value in the splat file
  std::optional<double> eps2d;                      // likewise
  int downscale = 1;
  // Loading of scenes (apps/inputs/scene_and_splat.h).
  std::string images = "images", test_list;
  bool allow_missing = false;
  std::optional<int> test_every;          // none: the split of the scene, or every 8th
  std::optional<double> photographs_mib;  // none: half of the available memory
  Align align = Align::kNone;
  Device device = Device::kAuto;
  int threads = 0;
  std::string view;                // train: port of the page, or "auto"; empty: no page
  std::string bind = "127.0.0.1";  // address on which the viewer listens
  std::optional<int> port;         // none: the first free one
  bool quiet = false;
  bool log_lm = false;
  bool profile = false;
  // bundle_adjust.
  std::optional<int> iterations, pcg_iterations;  // none: the defaults of LmOptions
  double time_limit = 0;
  std::string loss = "none";
  double loss_scale = 1;
};

// The groups of flags, in the order of the help.
enum class FlagGroup { kInput, kQuality, kOutput, kBrowser, kResources, kOther };
const char* Heading(FlagGroup group);
// The group of an option of TrainFields() that has its own flag.
FlagGroup GroupOf(const schema::FieldInfo& option);

struct FlagRow {
  FlagGroup group;
  unsigned commands;  // the commands that accept it
  schema::Field<Flags> field;
  unsigned rare_for = 0;          // commands whose help lists it only with --all
  const char* if_bare = nullptr;  // value of the flag without "=VALUE"; null: a value is required
};
const std::vector<FlagRow>& ProgramFlags();

// A training option from the command line, given by its own flag or by --set.
struct GivenOption {
  const schema::Field<gs::TrainOptions>* field;
  std::string value;  // a valid value of the field
};

struct CommandLine {
  const CommandInfo* command = nullptr;  // null: help
  std::vector<std::string> arguments;    // for help: the topic, if any, and --all
  Flags flags = {};
  std::vector<GivenOption> options = {};  // in the order given; the last value of a field wins
};

// Whether the command accepts the option. train and config accept all; refine and prune accept the options that an
// existing splat leaves open.
bool TakesOption(const CommandInfo& command, const schema::FieldInfo& option);

}  // namespace vesta::app
