// What is taken out of the model in the course of the Adam stage (parsimony/schedule.h). Judged on the host, by the
// training views at full size whatever the iterations see.
#pragma once

#include <fmt/format.h>

#include <type_traits>
#include <vector>

#include "problems/gaussian_splatting/parsimony/prune.h"
#include "problems/gaussian_splatting/parsimony/schedule.h"
#include "problems/gaussian_splatting/parsimony/support.h"
#include "problems/gaussian_splatting/train/adam_stage_state.h"
#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/stage_pace.h"

namespace vesta::gs {

template <class B>
class StageParsimony {
 public:
  // pace: is told how long judging takes.
  StageParsimony(TrainingSession& session, StagePace& pace)
      : session_(session), options_(session.options().parsimony), pace_(pace) {}

  // What goes after the iteration that state.span says; Gaussians have been added before, by what was observed of them.
  // degree: of the harmonics in use. before_change() is called where some go.
  template <class BeforeChange>
  void TakeOut(AdamStageState<B>& state, int degree, const BeforeChange& before_change) {
    const auto keep_only = [&](const std::vector<Index>& kept) {
      if (static_cast<Index>(kept.size()) == state.model.count()) return;
      before_change();
      state.model.Keep(kept);
    };
    if (ChecksSupport(options_, state.span)) keep_only(Supported(OnHost(state, degree), Judges()));
    if (!Prunes(options_, state.span)) return;
    if (state.before_pruning == 0) state.before_pruning = state.model.count();
    const Index judged = state.model.count(), left = CountAfter(options_, state.span, state.before_pruning);
    if (options_.prunes_to_count() && left >= judged) return;
    const double begin = session_.Seconds();
    const Ranking ranking{options_.criterion, options_.supported, session_.options().seed};
    const splat::Model<float> model = OnHost(state, degree);
    keep_only(options_.prunes_to_count() ? Keepers(model, Judges(), ranking, left)
                                         : WorthTheirPrice(model, Judges(), PriceAt(options_, state.span)));
    pace_.ObserveJudging(judged, session_.Seconds() - begin);
    copy_ = SplatModel();
  }

  // Where the stage is over and more are left than were to be.
  void NoteWhoStayed(const AdamStageState<B>& state) const {
    const Index all = state.before_pruning > 0 ? state.before_pruning : state.model.count();
    const Index wanted = CountAfter(options_, {1, 1}, all);
    if (!options_.prunes_to_count() || state.model.count() <= wanted) return;
    session_.Note(fmt::format("{} Gaussians are left, not the {} of parsimony.keep={}: the stage ended before",
                              state.model.count(), wanted, options_.keep));
  }

 private:
  // Until the next call.
  splat::Model<float> OnHost(const AdamStageState<B>& state, int degree) {
    splat::Model<float> model = state.model.kernel_model(degree);
    if constexpr (!std::is_same_v<typename B::Space, Host>) {
      state.model.DownloadParameters(copy_);
      model.x = copy_.data.data();
    }
    return model;
  }
  JudgingViews Judges() const { return TrainingViewsOf(session_.scene(), session_.options().background); }

  TrainingSession& session_;
  const ParsimonyOptions& options_;
  StagePace& pace_;
  SplatModel copy_;  // of a device's model
};

}  // namespace vesta::gs
