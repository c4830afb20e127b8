// SPDX-License-Identifier: GPL-3.0-or-later
// Right-looking supernodal Cholesky. Every panel gets the entries of A that are its own, and the
// updates of the panels before it add to them; when its turn comes it is factored and its own
// update goes straight from registers to the panels of its ancestors. All places are looked up in
// analyze; factorize and solve only compute.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <vector>

#include "server/mechanics/sparse/elimination.h"
#include "server/mechanics/sparse/factor.h"
#include "server/mechanics/sparse/kernels/panel_kernels.h"

namespace tenter::mechanics {

namespace {

int padded(int rows) {
  return (rows + kBlock - 1) / kBlock * kBlock;
}

/// Doubles on a cache line, of which there may not be enough.
class AlignedArray {
 public:
  bool resize(std::size_t size) {
    data_.reset();
    size_ = 0;
    void* raw = ::operator new (size * sizeof(double), std::align_val_t{64}, std::nothrow);
    data_.reset(static_cast<double*>(raw));
    if (raw != nullptr) size_ = size;
    clear();
    return raw != nullptr;
  }
  void clear() {
    if (size_ > 0) std::memset(data_.get(), 0, size_ * sizeof(double));
  }
  double* data() const { return data_.get(); }
  std::size_t size() const { return size_; }

 private:
  struct Release {
    void operator()(double* data) const { ::operator delete (data, std::align_val_t{64}); }
  };
  std::unique_ptr<double, Release> data_;
  std::size_t size_ = 0;
};

/// Right-hand sides that are solved together: kBlock times so many.
constexpr int kMostBlocks = 4;

class SupernodalFactor final : public SparseFactor {
 public:
  explicit SupernodalFactor(const PanelKernels& kernels) : kernels_(kernels) {}

  void analyze(const SymmetricPattern& pattern) override;
  [[nodiscard]] FactorStatus factorize(const double* values) override;
  void solve(const double* right_sides, double* solutions, int count) override;
  FactorCost cost() const override;

 private:
  /// An entry of A and its place in its panel.
  struct Entry {
    int source;
    int place;
  };

  void place_entries(const SymmetricPattern& pattern, const std::vector<int>& owner);
  void place_updates(const std::vector<int>& owner);
  void open_panel(int s, const double* values);
  void solve_one(const double* right_side, double* solution);
  void forward_block(int s, double* y);
  void backward_block(int s, double* y);
  void solve_blocks(const double* right_sides, double* solutions, int count);

  int rows(int s) const { return padded(shape_.height(s)); }
  double* panel(int s) const { return values_.data() + panel_start_[s]; }

  const PanelKernels& kernels_;
  SupernodalStructure shape_;
  bool fits_ = true;
  int entry_count_ = 0;
  std::vector<int> diagonal_;             ///< [size] entry of A on the diagonal of each new column
  std::vector<int> entry_start_;          ///< [supernodes + 1] into entries_
  std::vector<Entry> entries_;            ///< of A, by panel
  std::vector<char> is_open_;             ///< [supernodes] whether the panel holds its part of A
  std::vector<std::size_t> panel_start_;  ///< [supernodes] in values_
  std::vector<int> update_start_;         ///< [supernodes + 1] into updates_
  std::vector<PanelUpdate> updates_;
  std::vector<int> update_columns_, run_start_;
  std::vector<RowRun> runs_;
  AlignedArray values_;
  std::vector<double> smallest_pivot_, inverse_pivot_;
  AlignedArray unknowns_, gathered_;  ///< blocks of right-hand sides: all rows; one panel's
};

void SupernodalFactor::analyze(const SymmetricPattern& pattern) {
  shape_ = supernodal_structure(pattern);
  entry_count_ = pattern.entry_count();
  const int supernodes = shape_.count();
  std::vector<int> owner(pattern.size);
  std::size_t total = 0;
  int highest = 0;
  panel_start_.clear();
  for (int s = 0; s < supernodes; ++s) {
    std::fill_n(owner.begin() + shape_.column_start[s], shape_.width(s), s);
    panel_start_.push_back(total);
    total += static_cast<std::size_t>(rows(s)) * shape_.width(s);
    highest = std::max(highest, rows(s));
  }
  is_open_.assign(supernodes, 0);
  smallest_pivot_.assign(pattern.size, 0.0);
  inverse_pivot_.assign(pattern.size, 0.0);
  // a tile may read, though not use, up to a block behind the last panel
  fits_ = values_.resize(total + kBlock) &&
          unknowns_.resize(static_cast<std::size_t>(pattern.size) * kBlock) &&
          gathered_.resize(static_cast<std::size_t>(highest) * kBlock);
  if (!fits_) return;
  place_entries(pattern, owner);
  place_updates(owner);
}

void SupernodalFactor::place_entries(const SymmetricPattern& pattern,
                                     const std::vector<int>& owner) {
  std::vector<int> place(pattern.size);
  for (int i = 0; i < pattern.size; ++i) place[shape_.order[i]] = i;
  diagonal_.resize(pattern.size);
  std::vector<std::vector<Entry>> by_panel(shape_.count());
  for (int old = 0; old < pattern.size; ++old) {
    diagonal_[place[old]] = pattern.column_start[old];
    for (int p = pattern.column_start[old]; p < pattern.column_start[old + 1]; ++p) {
      const int col = std::min(place[old], place[pattern.row[p]]);
      const int row = std::max(place[old], place[pattern.row[p]]);
      const int s = owner[col];
      const auto first = shape_.rows.begin() + shape_.row_start[s];
      const auto last = shape_.rows.begin() + shape_.row_start[s + 1];
      const int local_row = static_cast<int>(std::lower_bound(first, last, row) - first);
      by_panel[s].push_back({p, (col - shape_.column_start[s]) * rows(s) + local_row});
    }
  }
  entries_.clear();
  entry_start_.assign(1, 0);
  for (const std::vector<Entry>& entries : by_panel) {
    entries_.insert(entries_.end(), entries.begin(), entries.end());
    entry_start_.push_back(static_cast<int>(entries_.size()));
  }
}

// The rows below a panel's triangle, taken together by the supernode that has them as columns, are
// one update each; its target has all rows from there on, and where they lie is written down as
// runs inside blocks of kBlock rows.
void SupernodalFactor::place_updates(const std::vector<int>& owner) {
  updates_.clear();
  update_columns_.clear();
  run_start_.clear();
  runs_.clear();
  update_start_.assign(1, 0);
  std::vector<std::size_t> columns_at, runs_at;
  for (int s = 0; s < shape_.count(); ++s) {
    const int* row = shape_.rows.data() + shape_.row_start[s];
    const int height = shape_.height(s);
    for (int first = shape_.width(s), last = first; first < height; first = last) {
      PanelUpdate update;
      update.target = owner[row[first]];
      update.first_row = first;
      while (last < height && owner[row[last]] == update.target) ++last;
      update.columns = last - first;
      update.blocks = (height - first + kBlock - 1) / kBlock;
      columns_at.push_back(update_columns_.size());
      runs_at.push_back(run_start_.size());
      for (int r = first; r < last; ++r)
        update_columns_.push_back(row[r] - shape_.column_start[update.target]);
      const int* place = shape_.rows.data() + shape_.row_start[update.target];
      int local = 0;
      for (int r = first; r < height; ++r) {
        while (place[local] != row[r]) ++local;
        const int lane = (r - first) % kBlock;
        if (lane == 0) run_start_.push_back(static_cast<int>(runs_.size()));
        if (lane == 0 || runs_.back().offset != local - lane) runs_.push_back({local - lane, 0});
        runs_.back().rows |= 1u << lane;
      }
      run_start_.push_back(static_cast<int>(runs_.size()));
      updates_.push_back(update);
    }
    update_start_.push_back(static_cast<int>(updates_.size()));
  }
  for (std::size_t u = 0; u < updates_.size(); ++u) {
    updates_[u].column = update_columns_.data() + columns_at[u];
    updates_[u].run_start = run_start_.data() + runs_at[u];
    updates_[u].runs = runs_.data();
  }
}

// Just before its first update, so that a panel is cleared, filled and updated while it is in
// cache.
void SupernodalFactor::open_panel(int s, const double* values) {
  if (is_open_[s] != 0) return;
  is_open_[s] = 1;
  double* entries = panel(s);
  std::memset(entries, 0, sizeof(double) * rows(s) * shape_.width(s));
  for (int e = entry_start_[s]; e < entry_start_[s + 1]; ++e)
    entries[entries_[e].place] = values[entries_[e].source];
}

FactorStatus SupernodalFactor::factorize(const double* values) {
  if (!fits_) return FactorStatus::out_of_memory;
  std::fill(is_open_.begin(), is_open_.end(), 0);
  for (std::size_t i = 0; i < diagonal_.size(); ++i)
    smallest_pivot_[i] = std::max(0.0, kTinyPivot * values[diagonal_[i]]);

  for (int s = 0; s < shape_.count(); ++s) {
    const int column = shape_.column_start[s];
    open_panel(s, values);
    if (!kernels_.factor(panel(s), rows(s), shape_.width(s), smallest_pivot_.data() + column,
                         inverse_pivot_.data() + column)) {
      const bool finite = std::all_of(values, values + entry_count_,
                                      [](double value) { return std::isfinite(value); });
      return finite ? FactorStatus::not_positive_definite : FactorStatus::not_finite;
    }
    for (int u = update_start_[s]; u < update_start_[s + 1]; ++u) {
      const int target = updates_[u].target;
      open_panel(target, values);
      kernels_.update(panel(s), rows(s), shape_.width(s), updates_[u], panel(target), rows(target));
    }
  }
  return FactorStatus::ok;
}

void SupernodalFactor::solve(const double* right_sides, double* solutions, int count) {
  const std::size_t size = shape_.order.size();
  if (count == 1) return solve_one(right_sides, solutions);
  // scratch for as many as are asked for, up to kMostBlocks, as far as there is memory
  const int wanted = kBlock * std::min(kMostBlocks, (count + kBlock - 1) / kBlock);
  if (unknowns_.size() < wanted * size && !unknowns_.resize(wanted * size))
    fits_ = unknowns_.resize(kBlock * size);
  if (!fits_ || size == 0) return;
  const int together = static_cast<int>(unknowns_.size() / size);
  for (int done = 0; done < count; done += together)
    solve_blocks(right_sides + done * size, solutions + done * size,
                 std::min(together, count - done));
}

void SupernodalFactor::solve_one(const double* right_side, double* solution) {
  double* y = unknowns_.data();
  double* x = gathered_.data();
  const int size = static_cast<int>(shape_.order.size());
  for (int i = 0; i < size; ++i) y[i] = right_side[shape_.order[i]];
  for (int s = 0; s < shape_.count(); ++s) {
    const int first = shape_.column_start[s], width = shape_.width(s), height = shape_.height(s);
    const int* row = shape_.rows.data() + shape_.row_start[s];
    std::copy_n(y + first, width, x);
    std::fill(x + width, x + rows(s), 0.0);
    kernels_.forward(panel(s), rows(s), width, inverse_pivot_.data() + first, x);
    std::copy_n(x, width, y + first);
    for (int r = width; r < height; ++r) y[row[r]] += x[r];
  }
  for (int s = shape_.count() - 1; s >= 0; --s) {
    const int first = shape_.column_start[s], width = shape_.width(s), height = shape_.height(s);
    const int* row = shape_.rows.data() + shape_.row_start[s];
    for (int r = 0; r < height; ++r) x[r] = y[row[r]];
    std::fill(x + height, x + rows(s), 0.0);
    kernels_.backward(panel(s), rows(s), width, inverse_pivot_.data() + first, x);
    std::copy_n(x, width, y + first);
  }
  for (int i = 0; i < size; ++i) solution[shape_.order[i]] = y[i];
}

void SupernodalFactor::forward_block(int s, double* y) {
  const int first = shape_.column_start[s], width = shape_.width(s), height = shape_.height(s);
  const int* row = shape_.rows.data() + shape_.row_start[s];
  double* x = gathered_.data();
  std::copy_n(y + first * kBlock, width * kBlock, x);
  std::fill(x + width * kBlock, x + rows(s) * kBlock, 0.0);
  kernels_.forward_block(panel(s), rows(s), width, inverse_pivot_.data() + first, x);
  std::copy_n(x, width * kBlock, y + first * kBlock);
  for (int r = width; r < height; ++r)
    for (int k = 0; k < kBlock; ++k) y[row[r] * kBlock + k] += x[r * kBlock + k];
}

void SupernodalFactor::backward_block(int s, double* y) {
  const int first = shape_.column_start[s], width = shape_.width(s), height = shape_.height(s);
  const int* row = shape_.rows.data() + shape_.row_start[s];
  double* x = gathered_.data();
  for (int r = 0; r < height; ++r) std::copy_n(y + row[r] * kBlock, kBlock, x + r * kBlock);
  std::fill(x + height * kBlock, x + rows(s) * kBlock, 0.0);
  kernels_.backward_block(panel(s), rows(s), width, inverse_pivot_.data() + first, x);
  std::copy_n(x, width * kBlock, y + first * kBlock);
}

// Every panel is read once for all blocks of right-hand sides: reading L is what a solve costs.
void SupernodalFactor::solve_blocks(const double* right_sides, double* solutions, int count) {
  const std::size_t size = shape_.order.size();
  const int blocks = (count + kBlock - 1) / kBlock;
  const auto unknowns = [&](int block) { return unknowns_.data() + block * size * kBlock; };
  for (int block = 0; block < blocks; ++block) {
    const double* from = right_sides + block * kBlock * size;
    const int width = std::min(kBlock, count - block * kBlock);
    double* y = unknowns(block);
    for (std::size_t i = 0; i < size; ++i)
      for (int k = 0; k < kBlock; ++k)
        y[i * kBlock + k] = k < width ? from[k * size + shape_.order[i]] : 0.0;
  }
  for (int s = 0; s < shape_.count(); ++s)
    for (int block = 0; block < blocks; ++block) forward_block(s, unknowns(block));
  for (int s = shape_.count() - 1; s >= 0; --s)
    for (int block = 0; block < blocks; ++block) backward_block(s, unknowns(block));
  for (int block = 0; block < blocks; ++block) {
    double* to = solutions + block * kBlock * size;
    const int width = std::min(kBlock, count - block * kBlock);
    const double* y = unknowns(block);
    for (std::size_t i = 0; i < size; ++i)
      for (int k = 0; k < width; ++k) to[k * size + shape_.order[i]] = y[i * kBlock + k];
  }
}

template <class T>
std::size_t bytes_of(const std::vector<T>& list) {
  return list.capacity() * sizeof(T);
}

FactorCost SupernodalFactor::cost() const {
  FactorCost cost;
  cost.flops = shape_.flops;
  cost.factor_entries = static_cast<double>(values_.size());
  cost.bytes = sizeof(double) * (values_.size() + unknowns_.size() + gathered_.size()) +
               bytes_of(shape_.order) + bytes_of(shape_.column_start) + bytes_of(shape_.row_start) +
               bytes_of(shape_.rows) + bytes_of(diagonal_) + bytes_of(entry_start_) +
               bytes_of(entries_) + bytes_of(is_open_) + bytes_of(panel_start_) +
               bytes_of(update_start_) + bytes_of(updates_) + bytes_of(update_columns_) +
               bytes_of(run_start_) + bytes_of(runs_) + bytes_of(smallest_pivot_) +
               bytes_of(inverse_pivot_);
  return cost;
}

}  // namespace

std::unique_ptr<SparseFactor> make_supernodal_factor(InstructionSet wanted) {
  const std::vector<const PanelKernels*> runnable = runnable_panel_kernels();
  const PanelKernels* chosen = runnable.front();
  for (const PanelKernels* kernels : runnable) {
    if ((wanted == InstructionSet::avx2 && kernels == &kAvx2Kernels) ||
        (wanted == InstructionSet::portable && kernels == &kPortableKernels))
      chosen = kernels;
  }
  return std::make_unique<SupernodalFactor>(*chosen);
}

}  // namespace tenter::mechanics
