// SPDX-License-Identifier: Apache-2.0
// The flags of all commands, and a command line with its arguments, flags and options.
#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernels/core/schema.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {

// A command line that cannot be understood. what() is one line that says what to do.
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
  const char* output = nullptr;    // what --out names, where the command needs it
  bool repeats = false;            // the last argument may be given more than once
  const char* optional = nullptr;  // an argument after the others, which may be left out
};
const std::vector<CommandInfo>& Commands();
// Null where there is none of that name.
const CommandInfo* FindCommand(const std::string& name);
// How the command is written, without the flags that may be left out: "vesta train SCENE --out=DIR".
std::string UsageForm(const CommandInfo& command);

// What eval fits to each test view before it measures a second time.
enum class Align { kNone, kPose, kPoseAndColor };

// What render shows of a view.
enum class Show { kColor, kDepth, kMedianDepth, kNormals };
constexpr bool IsDepth(Show show) { return show == Show::kDepth || show == Show::kMedianDepth; }

enum class Device { kAuto, kCpu, kCuda };

inline constexpr const char* kDefaultPreset = "balanced";
inline constexpr const char* kAnyPort = "auto";

// What the flags say; of those not given, what is here.
struct Flags {
  std::string out, json;
  std::string resume;                            // a folder with a checkpoint; empty: none
  std::string checkpoint_every, snapshot_every;  // as ParseInterval reads them; empty: never
  bool truth = false;
  // Of render: the cameras, and what becomes of them (render/camera_path.h).
  std::string path, size, film;  // empty: the test views, as the cameras have it, none
  std::optional<int> frames;     // none: as suits the path
  std::optional<double> fps;     // of the film; none: 30
  Show show = Show::kColor;
  // Of convert: what stays (splat_filters.h).
  std::string box;
  bool clean = false;
  bool report = true;                        // of a training, as report.html
  std::string scene;                         // of the runs that are reported; empty: as each says
  std::optional<double> max_loss, size_mib;  // of prune, which takes one of them or a part to keep
  std::optional<gs::RefineMethod> method;    // none: the preset's
  std::string preset;                        // empty: that of the file of --config, or kDefaultPreset
  std::string config;
  std::string set;  // never filled: CommandLine::options has them
  bool fixed_model = false;
  std::optional<std::array<double, 3>> background;  // none: what the splat states
  std::optional<double> eps2d;                      // likewise
  int downscale = 1;
  // How a scene is read (apps/inputs/scene_and_splat.h).
  std::string images = "images", test_list;
  bool allow_missing = false;
  std::optional<int> test_every;          // none: as the scene has it
  std::optional<double> photographs_mib;  // none: by the memory that there is
  Align align = Align::kNone;
  Device device = Device::kAuto;
  int threads = 0;
  std::string view;                // of a training, the port of its page, or "auto"; empty: there is none
  std::string bind = "127.0.0.1";  // where a viewer listens
  std::optional<int> port;         // none: a free one
  bool quiet = false;
  bool log_lm = false;
  bool profile = false;
  // Of bundle_adjust.
  std::optional<int> iterations, pcg_iterations;  // none: the engine's
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

// An option of training that was given, by its own flag or by --set.
struct GivenOption {
  const schema::Field<gs::TrainOptions>* field;
  std::string value;  // one of the field's
};

struct CommandLine {
  const CommandInfo* command = nullptr;  // null: help
  std::vector<std::string> arguments;    // of the command; of help its topic, if any, and --all
  Flags flags = {};
  std::vector<GivenOption> options = {};  // in the order given: the last of one field counts
};

// Whether the command takes the option: config and train take all, refine those that a given model leaves open.
bool TakesOption(const CommandInfo& command, const schema::FieldInfo& option);

}  // namespace vesta::app
