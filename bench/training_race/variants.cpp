#include "bench/training_race/variants.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/training_race/adam_schedules.h"
#include "bench/training_race/changes.h"

namespace vesta::bench {
namespace {

struct Row {
  const char *knob, *name;
  const char* changes;  // changes.h
};

// LM from the reference's state. A new option of LM is a line here for each of its values.
constexpr Row kLmRows[] = {
    {"noise", "initial lambda x 0.95", "lm.initial_lambda=x0.95"},
    {"noise", "initial lambda x 1.05", "lm.initial_lambda=x1.05"},

    {"PCG iterations", "2", "lm.pcg_iterations=2"},
    {"PCG iterations", "4", "lm.pcg_iterations=4"},
    {"PCG iterations", "6", "lm.pcg_iterations=6"},
    {"PCG iterations", "8", "lm.pcg_iterations=8"},
    {"PCG iterations", "16", "lm.pcg_iterations=16"},

    {"step control", "v2", "lm.step_control=v2"},
    {"step control", "code", "lm.step_control=code"},

    // diag(JtJ) is another scale: several starts.
    {"damping", "diag", "lm.damping=diag"},
    {"damping", "diag, from 0.1", "lm.damping=diag lm.initial_lambda=0.1"},
    {"damping", "diag, from 1", "lm.damping=diag lm.initial_lambda=1"},
    {"initial lambda", "x 0.1", "lm.initial_lambda=x0.1"},
    {"initial lambda", "x 10", "lm.initial_lambda=x10"},

    {"preconditioner", "jacobi", "lm.preconditioner=jacobi"},
    {"agreement of views", "0", "lm.view_agreement=0"},
    {"agreement of views", "0.1", "lm.view_agreement=0.1"},
    {"agreement of views", "1", "lm.view_agreement=1"},

    {"|error|", "as the square of its root", "lm.loss_linearization=sqrt"},
    {"|error|", "huber", "lm.loss_linearization=huber"},
    {"|error|", "l2", "lm.loss_linearization=l2"},
    {"SSIM", "root, centre", "lm.ssim=root_center"},

    {"Jacobian", "recompute", "lm.jacobian=recompute"},
    {"Jacobian", "cache32", "lm.jacobian=cache32"},
    {"Jacobian", "cache16", "lm.jacobian=cache16"},

    {"views a step", "8", "lm.batch_size=8"},
    {"views a step", "8, random", "lm.batch_size=8 lm.batch_choice=random"},
    {"batches", "2, exact sum", "lm.batches=2"},
    {"batches", "4, exact sum", "lm.batches=4"},
    {"batches", "2, merged", "lm.batches=2 lm.merge_batches=true"},
    {"batches", "4, merged", "lm.batches=4 lm.merge_batches=true"},

    {"line search", "30 % of the views", "lm.line_search=true lm.line_search_views=0.3"},
    {"line search", "all views", "lm.line_search=true lm.line_search_views=1"},

    {"floor of L1", "0.001", "lm.l1_floor=0.001"},
    {"floor of L1", "0.003", "lm.l1_floor=0.003"},
    {"floor of L1", "0.03", "lm.l1_floor=0.03"},

    {"preset", "fast", "lm=fast lm.iterations=8"},
    {"preset", "paper", "lm=paper"},
    {"preset", "paper_code", "lm=paper_code"},
};

// Whole trainings, as long as the reference's.
constexpr Row kWholeRows[] = {
    {"when to switch", "Adam x 0.25", "adam.iterations=x0.25"},
    {"when to switch", "Adam x 0.5", "adam.iterations=x0.5"},
    {"when to switch", "Adam x 0.75", "adam.iterations=x0.75"},
    {"when to switch", "after a cooldown, without a mean", "adam.cooldown=0.1 adam.average_part=0"},
    {"when to switch", "after a cooldown, and the mean", "adam.cooldown=0.1"},
    {"when to switch", "Adam x 1.5", "adam.iterations=x1.5"},
};

}  // namespace

std::vector<Variant> Variants(const gs::TrainOptions& reference, double budget) {
  std::vector<Variant> variants = {{"reference", "as given", reference, false}};
  for (const Row& row : kLmRows) variants.push_back({row.knob, row.name, Changed(reference, row.changes), false});
  for (const Row& row : kWholeRows) variants.push_back({row.knob, row.name, Changed(reference, row.changes), true});
  // As many views as the time of both stages allows, whatever the batch.
  const int whole = std::max(1, static_cast<int>((1 + budget) * *reference.adam.iterations));
  for (const int views : {1, 4, 16}) {
    variants.push_back({"no LM", views == 1 ? "Adam alone" : fmt::format("Adam alone, {} views an iteration", views),
                        LargeBatchAdam(reference, whole, reference.adam.rate_factor, views), true});
  }
  return variants;
}

}  // namespace vesta::bench
