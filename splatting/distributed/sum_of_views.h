// SPDX-License-Identifier: Apache-2.0
// The gradient of one view as a term, and the sum of the terms of an iteration in the order of a fixed tree. For every
// memory space.
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

// What one training view tells of a model, or several together: a block-sparse gradient, and a term of the sum that an
// iteration of Adam steps by.
// A term holds what the view sees, block by block of neighbouring Gaussians, and one view sees a part of them: to make,
// add and hand on terms costs in proportion to that. For every memory space.
template <class Space>
class ViewGradient {
 public:
  ViewGradient() = default;

  const ViewCost& cost() const { return header_.cost; }
  void SetCost(const ViewCost& cost) { header_.cost = cost; }
  // Blocks of term::kLanes Gaussians that it has, and rows of as many numbers in all.
  Index blocks() const { return header_.blocks; }
  Index rows() const { return header_.rows; }

  // On the host: all of it as bytes, for another process: numbers as this machine has them.
  HostSpan<const unsigned char> Bytes() {
    static_assert(std::is_same_v<Space, Host>);
    term::WriteHeader(header_, bytes_.data());
    return bytes_;
  }
  // Becomes the term of these bytes. Throws Error where they are of none.
  void Assign(HostSpan<const unsigned char> bytes) {
    header_ = term::ReadHeader(bytes);
    Reserve(bytes.size());
    bytes_.CopyFrom(bytes);
  }

  // Makes room for so many, whose contents mean nothing yet.
  void Lay(Index blocks, Index rows) {
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
  // With some room, since a term is recycled for others that are a little larger.
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

// Makes terms of one model and adds them; terms that are done with leave their memory to others. On a device all of it
// throws OutOfDeviceMemory.
template <class Space>
class ViewGradientPool {
 public:
  using Term = ViewGradient<Space>;

  // Takes the gradient of one view out of `gradient`, laid out as the model, which is zero outside of what the view
  // sees, and everywhere afterwards. pulls: of the view; how it pulls is left out where that is not asked for.
  Term Take(const term::Layout& layout, const density::Grad2dView& pulls, bool needs_grad2d, float* gradient) {
    counts_.ResizeForOverwrite(layout.Blocks() + 1);
    ForEach<Space>(layout.Blocks() + 1, kGrain, term::CountSeen{layout, pulls.rank_of, counts_.data()});
    Term term = TermOfCounted(layout);
    ForEachRow(layout, term, term::TakeRow{{layout, term.block()}, term.begin(), gradient, term.numbers()});
    ForEach<Space>(
        term.blocks(), kGrain,
        term::ObserveBlock{pulls, needs_grad2d, layout.model.count, term.block(), term.begin(), term.numbers()});
    return term;
  }

  // left + right.
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
  // The same into left, for a TreeSum.
  void Join(const term::Layout& layout, Term& left, Term right) {
    Term sum = Sum(layout, left, right);
    Recycle(std::exchange(left, std::move(sum)));
    Recycle(std::move(right));
  }

  // Puts the numbers of its Gaussians into an array laid out as the model: of the gradient, say.
  void Give(const term::Layout& layout, Term& term, float* to) const {
    ForEachRow(layout, term, term::GiveRow{{layout, term.block()}, term.arrays(), to});
  }
  // Adds what was observed of each Gaussian: the sum of its pulls, and how many views saw it.
  void GiveGrad2d(const term::Layout& layout, Term& term, float* pull, int* seen) const {
    ForEach<Space>(term.blocks(), kGrain, term::GiveGrad2d{term.arrays(), layout.model.count, pull, seen});
  }
  void Recycle(Term term) {
    if (term.has_memory()) spare_.push_back(std::move(term));
  }
  // One that was recycled, whose contents mean nothing, or a new one.
  Term TakeSpare() {
    if (spare_.empty()) return {};
    Term term = std::move(spare_.back());
    spare_.pop_back();
    return term;
  }

 private:
  static constexpr Index kGrain = 1024, kRowGrain = 4096;

  // Blocks and rows as counts_ says; numbers that mean nothing yet.
  Term TermOfCounted(const term::Layout& layout) {
    sums_.ResizeForOverwrite(layout.Blocks() + 1);
    const Index all = Sorting<Space>::RunningSum(counts_, sums_);
    Term term = TakeSpare();
    term.Lay(term::BlocksOf(all), term::RowsOf(all));
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

// What the views of an iteration tell of a model, added up in the order of a fixed tree (kernels/ranks/sum_tree.h): the
// same bits whoever took which view. For every memory space.
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
  void Add(Index k, const density::Grad2dView& pulls, float* gradient, const Cost& cost) {
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
    if (density_) terms_.GiveGrad2d(layout_, whole, density_->pull().data(), density_->seen().data());
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
