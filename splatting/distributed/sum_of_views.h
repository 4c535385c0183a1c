// SPDX-License-Identifier: Apache-2.0
// What the views of an iteration tell of a model, added up in the order of a fixed tree (kernels/ranks/sum_tree.h): the
// same bits whoever took which view. For every memory space.
#pragma once

#include <utility>
#include <vector>

#include "kernels/ranks/sum_tree.h"
#include "splatting/density/density.h"
#include "splatting/distributed/view_gradient.h"

namespace vesta::gs {

template <class Space>
class SumOfViews {
 public:
  using Term = ViewGradient<Space>;
  using Tree = TreeSum<Term>;
  using Part = typename Tree::Part;

  // An iteration on so many views of a model so laid out; what was left of another one is dropped. density: learns how
  // the views pull; may be null.
  void Begin(const term::Layout& layout, Index views, DensityControl<Space>* density) {
    layout_ = layout, density_ = density, views_ = views;
    tree_ = Tree(views);
  }
  Index num_gaussians() const { return layout_.model.count; }
  // View k of the iteration has left its gradient in `gradient`, laid out as the model, which was zero before. Where
  // there are more views it is taken from there (ViewGradientPool::Take). cost() is asked for last.
  template <class Cost>
  void Add(Index k, const density::ScreenPulls& pulls, float* gradient, const Cost& cost) {
    if (views_ == 1) {
      if (density_) density_->Observe(pulls);
      cost_ = cost();
      return;
    }
    Term term = terms_.Take(layout_, pulls, density_ != nullptr, gradient);
    term.SetCost(cost());
    AddPart({TreeNode{k, k + 1}, std::move(term)});
  }
  // Of several views: some of them, that were added up elsewhere.
  void AddPart(Part part) {
    tree_.Push(part.first, std::move(part.second), [&](const TreeNode&, Term& left, const TreeNode&, Term& right) {
      terms_.Join(layout_, left, std::move(right));
    });
  }
  // The same of one that came as its bytes.
  void AddPart(const TreeNode& node, HostSpan<const unsigned char> bytes) {
    Term term = terms_.TakeSpare();
    term.Assign(bytes);
    AddPart({node, std::move(term)});
  }
  // Those that were added here, as far as they can be without the others.
  std::vector<Part> TakeParts() { return tree_.TakeParts(); }

  // Once all views were added: leaves their gradient in `gradient`, tells density control, and returns their cost.
  ViewCost Finish(float* gradient) {
    if (views_ == 1) return cost_;
    Term whole = tree_.TakeWhole();
    terms_.Give(layout_, whole, gradient);
    if (density_) terms_.GivePulls(layout_, whole, density_->pull().data(), density_->seen().data());
    const ViewCost cost = whole.cost();
    terms_.Recycle(std::move(whole));
    return cost;
  }

 private:
  term::Layout layout_{};
  DensityControl<Space>* density_ = nullptr;
  Index views_ = 1;
  Tree tree_{1};   // of several views
  ViewCost cost_;  // of one
  ViewGradientPool<Space> terms_;
};

}  // namespace vesta::gs
