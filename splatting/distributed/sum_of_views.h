// SPDX-License-Identifier: Apache-2.0
// The gradient of one view in block-sparse form (a "term"), and sums of terms in the order of a fixed tree. Space: Host
// or Device.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/sort.h"
#include "kernels/ranks/sum_tree.h"
#include "splatting/density/density.h"
#include "splatting/distributed/term_exchange.h"
#include "splatting/distributed/view_gradient_steps.h"

namespace vesta::gs {

// A term: the block-sparse gradient of one view, or the sum of several, in an iteration of Adam. A block is 16
// Gaussians, neighbours in memory. A term has only the visible blocks, so its cost is proportional to their number.
template <class Space>
class ViewGradient {
 public:
  ViewGradient() = default;

  const ViewCost& cost() const { return header_.cost; }
  void SetCost(const ViewCost& cost) { header_.cost = cost; }
  // blocks(): number of blocks of term::kLanes Gaussians. rows(): rows of all blocks, of term::kLanes numbers: one row
  // for each attribute and statistic of a block (view_gradient_steps.h).
  Index blocks() const { return header_.blocks; }
  Index rows() const { return header_.rows; }

  // Bytes to send to another process, in the byte order of this machine. Host only.
  HostSpan<const unsigned char> Bytes() {
    static_assert(std::is_same_v<Space, Host>);
    term::WriteHeader(header_, bytes_.data());
    return bytes_;
  }
  // The inverse of Bytes(). Throws Error if the bytes are not a term.
  void Assign(HostSpan<const unsigned char> bytes) {
    header_ = term::ReadHeader(bytes);
    Reserve(bytes.size());
    bytes_.CopyFrom(bytes);
  }

  // Does not initialise the arrays.
  void Allocate(Index blocks, Index rows) {
    header_.blocks = blocks, header_.rows = rows;
    Reserve(term::SizeOf(header_));
    bytes_.ResizeForOverwrite(term::SizeOf(header_));
  }
  std::uint32_t* block() { return At<std::uint32_t>(term::BlockAt()); }
  std::uint32_t* begin() { return At<std::uint32_t>(term::BeginAt(blocks())); }
  float* numbers() { return At<float>(term::RowsAt(blocks())); }
  term::Arrays arrays() { return {block(), begin(), numbers()}; }
  bool has_memory() const { return bytes_.capacity() > 0; }

 private:
  // Allocates a little more, since this memory is recycled for slightly larger terms.
  void Reserve(Index size) {
    if (size > bytes_.capacity()) bytes_.ResizeForOverwrite(size + size / 4);
  }
  template <class T>
  T* At(Index offset) {
    return reinterpret_cast<T*>(bytes_.data() + offset);
  }

  term::Header header_;
  Buffer<unsigned char, Space> bytes_;
};

// Makes and adds terms of one model, and recycles their memory. On a device, every function throws OutOfDeviceMemory if
// memory runs out.
template <class Space>
class ViewGradientPool {
 public:
  using Term = ViewGradient<Space>;

  // Moves the gradient of one view from `gradient` to a new term. `gradient` has the layout of the model, with zeros
  // for Gaussians outside the view; afterwards it is zero. pull_view: pulls of the view, copied to the term if
  // needs_pull.
  Term Extract(const term::Layout& layout, const density::PullView& pull_view, bool needs_pull, float* gradient) {
    counts_.ResizeForOverwrite(layout.Blocks() + 1);
    ForEach<Space>(layout.Blocks() + 1, kGrain, term::CountVisible{layout, pull_view.rank_of, counts_.data()});
    Term term = TermOfCounted(layout);
    ForEachRow(layout, term, term::ExtractRow{{layout, term.block()}, term.begin(), gradient, term.numbers()});
    ForEach<Space>(
        term.blocks(), kGrain,
        term::ObserveBlock{pull_view, needs_pull, layout.model.count, term.block(), term.begin(), term.numbers()});
    return term;
  }

  Term Sum(const term::Layout& layout, Term& left, Term& right) {
    for (auto& [places, term] : {std::pair(&left_places_, &left), std::pair(&right_places_, &right)}) {
      places->Resize(layout.Blocks());
      ForEach<Space>(term->blocks(), kGrain, term::PlaceBlocks{term->block(), places->data()});
    }
    counts_.ResizeForOverwrite(layout.Blocks() + 1);
    ForEach<Space>(layout.Blocks() + 1, kGrain,
                   term::CountEither{layout, left_places_.data(), right_places_.data(), counts_.data()});
    Term sum = TermOfCounted(layout);
    ForEachRow(layout, sum,
               term::AddRow{{layout, sum.block()},
                            sum.begin(),
                            left_places_.data(),
                            right_places_.data(),
                            left.arrays(),
                            right.arrays(),
                            sum.numbers()});
    sum.SetCost({left.cost().objective + right.cost().objective, left.cost().values + right.cost().values});
    return sum;
  }
  // left += right, for TreeSum (sum_tree.h).
  void Join(const term::Layout& layout, Term& left, Term right) {
    Term sum = Sum(layout, left, right);
    Recycle(std::exchange(left, std::move(sum)));
    Recycle(std::move(right));
  }

  // Copies the gradient in `term` to `to`, which has the layout of the model. Blocks that the term lacks stay
  // unchanged.
  void CopyTo(const term::Layout& layout, Term& term, float* to) const {
    ForEachRow(layout, term, term::CopyRow{{layout, term.block()}, term.arrays(), to});
  }
  // Adds the pulls in `term` to `pull`, one number per Gaussian.
  void AddPull(const term::Layout& layout, Term& term, float* pull) const {
    ForEach<Space>(term.blocks(), kGrain, term::AddPull{term.arrays(), layout.model.count, pull});
  }
  // Keeps the memory of a term for later ones.
  void Recycle(Term term) {
    if (term.has_memory()) spare_.push_back(std::move(term));
  }
  // A recycled term with undefined contents, or an empty one.
  Term TakeSpare() {
    if (spare_.empty()) return {};
    Term term = std::move(spare_.back());
    spare_.pop_back();
    return term;
  }

 private:
  static constexpr Index kGrain = 1024, kRowGrain = 4096;

  // A term with the blocks and rows in counts_ (term::PackCounts). Its numbers are not initialised.
  Term TermOfCounted(const term::Layout& layout) {
    sums_.ResizeForOverwrite(layout.Blocks() + 1);
    const Index all = Sorting<Space>::RunningSum(counts_, sums_);
    Term term = TakeSpare();
    term.Allocate(term::UnpackBlocks(all), term::UnpackRows(all));
    ForEach<Space>(layout.Blocks(), kGrain, term::ListBlocks{counts_.data(), sums_.data(), term.block(), term.begin()});
    return term;
  }
  template <class F>
  static void ForEachRow(const term::Layout& layout, const Term& term, const F& f) {
    ForEach<Space>(term.blocks() * layout.MostRows(), kRowGrain, f);
  }

  Buffer<Index, Space> counts_, sums_;
  Buffer<std::uint32_t, Space> left_places_, right_places_;
  std::vector<Term> spare_;
};

// Sum of the gradients of an iteration's views, in the order of a fixed tree (kernels/ranks/sum_tree.h). So its bits do
// not depend on which process computed which view.
template <class Space>
class SumOfViews {
 public:
  using Term = ViewGradient<Space>;
  using Tree = TreeSum<Term>;
  using Part = typename Tree::Part;

  // Starts an iteration with `views` views; discards an unfinished one. density: receives the density statistics; null:
  // not needed.
  void Begin(const term::Layout& layout, Index views, DensityControl<Space>* density) {
    layout_ = layout, density_ = density, views_ = views;
    tree_ = Tree(views);
  }
  Index num_gaussians() const { return layout_.model.count; }
  // Adds view k of the iteration. `gradient` has the layout of the model, with zeros outside the view. If the iteration
  // has several views, `gradient` is moved to a term, and is zero afterwards. cost() returns the view's ViewCost; it is
  // called last, because it may wait for a device.
  template <class Cost>
  void Add(Index k, const density::PullView& pull_view, float* gradient, const Cost& cost) {
    if (views_ == 1) {
      if (density_) density_->Observe(pull_view);
      cost_ = cost();
      return;
    }
    Term term = terms_.Extract(layout_, pull_view, density_ != nullptr, gradient);
    term.SetCost(cost());
    AddPart({TreeNode{k, k + 1}, std::move(term)});
  }
  // Adds a term that was summed elsewhere, if the iteration has several views.
  void AddPart(Part part) {
    tree_.Push(part.first, std::move(part.second), [&](const TreeNode&, Term& left, const TreeNode&, Term& right) {
      terms_.Join(layout_, left, std::move(right));
    });
  }
  // Adds a term as bytes. node: the views of the term.
  void AddPart(const TreeNode& node, HostSpan<const unsigned char> bytes) {
    Term term = terms_.TakeSpare();
    term.Assign(bytes);
    AddPart({node, std::move(term)});
  }
  // Returns and removes the partial sums.
  std::vector<Part> TakeParts() { return tree_.TakeParts(); }

  // Call after all views were added. Stores the sum in `gradient`, updates the density statistics and returns the sum
  // of the costs.
  ViewCost Finish(float* gradient) {
    if (views_ == 1) return cost_;
    Term whole = tree_.TakeWhole();
    terms_.CopyTo(layout_, whole, gradient);
    if (density_) {
      terms_.AddPull(layout_, whole, density_->pull().data());
      density_->CountViews(views_);
    }
    const ViewCost cost = whole.cost();
    terms_.Recycle(std::move(whole));
    return cost;
  }

 private:
  term::Layout layout_{};
  DensityControl<Space>* density_ = nullptr;
  Index views_ = 1;
  Tree tree_{1};   // for several views
  ViewCost cost_;  // for one view
  ViewGradientPool<Space> terms_;
};

}  // namespace vesta::gs
