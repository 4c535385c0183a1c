// Where an LM stage starts: anew, or from what was saved.
#pragma once

#include <optional>
#include <string_view>
#include <utility>

#include "splatting/train/lm_stage/lm_state.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

class LmStart {
 public:
  // Throws Error, which names the checkpoint, where what was saved is no state of this stage.
  LmStart(TrainingSession& session, const SplatModel& model)
      : session_(session), saved_(session.saved().Take(Stage::kLm)), reader_(saved_ ? *saved_ : std::string_view()) {
    if (!saved_) {
      header = {model, 0, TrainingUnits(session, model)};
      return;
    }
    session.saved().OrRefuse([&] { reader_(header); });
    if (header.done < 0 || header.done > session.saved().first_iteration()) session.saved().Refuse();
  }
  LmStart(const LmStart&) = delete;
  LmStart& operator=(const LmStart&) = delete;

  bool saved() const { return saved_.has_value(); }
  // A stepper, by what it is made of and the saved solve; once. Throws as the constructor.
  template <class Stepper, class... Args>
  Stepper GoOn(Args&&... args) {
    return session_.saved().OrRefuse([&] { return Stepper(std::forward<Args>(args)..., reader_); });
  }
  // Iterations of the saved solve, whose best the model is that the stage begins with.
  int finished() const { return saved_ ? session_.saved().first_iteration() - header.done : 0; }

  LmStageHeader header;

 private:
  TrainingSession& session_;
  std::optional<std::string_view> saved_;
  ArchiveReader reader_;
};

}  // namespace vesta::gs
