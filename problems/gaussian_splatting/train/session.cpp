#include "problems/gaussian_splatting/train/session.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/model/view_owners.h"

namespace vesta::gs {

bool TrainingSession::Timer::IsDue(const Interval& interval, Stage stage, int iteration, double seconds) {
  const bool by_iterations = interval.iterations > 0 && (stage == Stage::kLm || iteration % interval.iterations == 0);
  const bool by_time = interval.minutes > 0 && seconds - last_seconds_ >= 60 * interval.minutes;
  if (by_iterations || by_time) last_seconds_ = seconds;
  return by_iterations || by_time;
}

std::string TrainingSession::NoteError(const char* what, const std::function<void()>& write) {
  try {
    write();
  } catch (const Error& error) {
    // What has been trained so far is not lost for want of a file.
    std::string line = fmt::format("{}: {}", what, error.what());
    if (notes_.empty() || notes_.back() != line) Note(line);
    return line;
  }
  return "";
}

void TrainingSession::SaveWhereDue(Stage stage, int iteration, const WriteState& state, const BeforeSaving& before) {
  if (!any_saves()) return;
  const CheckpointOptions& options = callbacks_.checkpoint;
  const auto is_due = [&] {
    const bool is_time = checkpoint_timer_.IsDue(options.every, stage, iteration, clock_.Seconds());
    const bool is_asked = callbacks_.watch.wants_checkpoint && callbacks_.watch.wants_checkpoint();
    return is_time || is_asked || (stopped_ && !options.every.never());
  };
  const bool is_own = saves() && is_due();
  if (before) {
    const std::vector<std::uint8_t> own{static_cast<std::uint8_t>(is_own ? 1 : 0)};
    const std::vector<std::uint8_t> all = trains_alone() ? own : GatherValues(*ranks(), own);
    if (std::ranges::count(all, 1) > 0) before({all.begin(), all.end()});
  }
  if (is_own) Save(stage, iteration, clock_.Seconds(), state);
}

void TrainingSession::Save(Stage stage, int iteration, double seconds, const WriteState& state) {
  const CheckpointOptions& options = callbacks_.checkpoint;
  RunState run{.origin = options.origin,
               .stage = stage,
               .iteration = iteration,
               .scene = fingerprint_,
               .seconds = seconds,
               .eval_seconds = clock_.Paused(),
               .history = history_,
               .notes = notes_,
               .cameras = cameras_.found()};
  const std::string error = NoteError("no checkpoint", [&] { WriteCheckpoint(options.path, run, state); });
  if (callbacks_.watch.saved) callbacks_.watch.saved(iteration, error);
}

void TrainingSession::AttendToWatch(Stage stage, int iteration, const std::function<splat::Model<float>()>& on_host,
                                    const WriteState& state) {
  const TrainWatch& watch = callbacks_.watch;
  bool is_shown = false;  // in a pause the model stays what it is
  const auto show_where_wanted = [&] {
    if (is_shown || !watch.wants_model || !watch.wants_model()) return;
    watch.show(on_host(), cameras_.found());
    is_shown = true;
  };
  show_where_wanted();
  if (!watch.waits) return;
  // What is done in a pause takes no time of the training either.
  const double seconds = clock_.Seconds();
  const TrainingClock::Absence absence(clock_);
  while (watch.waits()) {
    if (state && saves() && watch.wants_checkpoint && watch.wants_checkpoint()) Save(stage, iteration, seconds, state);
    show_where_wanted();
  }
}

void TrainingSession::SnapshotWhereDue(Stage stage, int iteration,
                                       const std::function<splat::Model<float>()>& on_host) {
  if (!callbacks_.snapshot) return;
  if (!snapshot_timer_.IsDue(callbacks_.snapshot_every, stage, iteration, clock_.Seconds())) return;
  NoteError("no snapshot", [&] { callbacks_.snapshot(stage, iteration, on_host()); });
}

double TrainingSession::SecondsForAdam(double seconds_per_pixel) const {
  if (options_.time_limit <= 0) return std::numeric_limits<double>::infinity();
  // Of the limit: what LM gets where it is asked for, and what files take to be written.
  constexpr double kPartOfLm = 0.25, kPartToWrite = 0.01;
  const double kept = kPartToWrite + (options_.lm.iterations > 0 ? kPartOfLm : 0);
  return (1 - kept) * options_.time_limit - clock_.Total() - EvaluationAhead(seconds_per_pixel);
}

double TrainingSession::EvaluationAhead(double seconds_per_pixel) const {
  // Of training on a view, which has a backward pass too.
  constexpr double kShareOfEvaluation = 0.5;
  if (latest_evaluation_ > 0) return latest_evaluation_;
  double pixels = 0;
  const std::vector<bool> are_measured = AreMeasured(measured_views(), scene().views);
  for (std::size_t v = 0; v < are_measured.size(); ++v) {
    const Camera& camera = scene().views[v].camera;
    if (are_measured[v]) pixels += static_cast<double>(camera.width) * camera.height;
  }
  return kShareOfEvaluation * seconds_per_pixel * pixels;
}

MemoryScene TrainingSession::CountMemory(const splat::Model<float>& model, Stage stage, int most,
                                         bool with_entries) const {
  MemoryScene counts = gs::CountMemory(model, PlannedViews(stage), NearPlane(scene()), most, with_entries);
  if (ranks()) {
    counts.is_bent = std::ranges::any_of(training_views(), [](const View* view) { return view->bent.has_value(); });
    counts.processes = ranks()->size();
    counts.parts = ViewRunsOf(static_cast<Index>(training_views().size()));
    counts.mask_bytes = mask_bytes_;  // of others' photographs nobody has the masks
  }
  return counts;
}

double TrainingSession::OwnMaskBytes() const {
  const Share own = OwnViewsInAdam(options_, ranks(), static_cast<Index>(training_views().size()));
  double bytes = 0;
  for (Index v = own.begin; v < own.end; ++v) {
    bytes += static_cast<double>(training_views()[static_cast<std::size_t>(v)]->image.mask.size());
  }
  return bytes;
}

std::optional<std::string> TrainingSession::TakeSavedStage(Stage stage) {
  return stage == first_stage() ? std::exchange(saved_stage_, std::nullopt) : std::nullopt;
}

void TrainingSession::RefuseSavedStage(const std::string& why) const {
  Fail("{}: holds no state that this training could have had{}; resume from another checkpoint, or train anew",
       callbacks_.resume->path, why.empty() ? "" : fmt::format(" ({})", why));
}

void TrainingSession::Resume(const Checkpoint& checkpoint) {
  if (checkpoint.run.scene != fingerprint_) {
    Fail("{}: of other photographs or cameras than this scene's; give the scene that it was trained on",
         checkpoint.path);
  }
  history_ = checkpoint.run.history;
  notes_ = checkpoint.run.notes;
  if (!cameras_.Restore(checkpoint.run.cameras)) RefuseSavedStage();
  saved_stage_ = checkpoint.stage_state;
}

std::vector<float> TrainingUnits(const TrainingSession& session, const SplatModel& model) {
  const Scene& scene = session.scene();
  return LengthUnits(model, session.training_views(), NearPlane(scene), scene.extent);
}

}  // namespace vesta::gs
