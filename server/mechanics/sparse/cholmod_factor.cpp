// SPDX-License-Identifier: GPL-3.0-or-later
// CHOLMOD behind the interface: supernodal L L', the better of AMD and METIS by the size of L, and
// a relaxation of the supernodes that was measured on cloth (wider leaves than CHOLMOD's default).
//
// Threads. Each call is held to one (one_thread.h), and no main has to know. OpenBLAS has no such
// scope: its number of threads belongs to the process and is set to one.
#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <vector>

#include "common/base/one_thread.h"
#include "server/mechanics/sparse/block_graph.h"
#include "server/mechanics/sparse/factor.h"

// Present when the BLAS is OpenBLAS; another BLAS leaves the pointer null.
extern "C" __attribute__((weak)) void openblas_set_num_threads(int count);

namespace tenter::mechanics {

namespace {

class CholmodFactor final : public SparseFactor {
 public:
  CholmodFactor() {
    if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.quick_return_if_not_posdef = 1;
    common_.nmethods = 2;
    common_.method[0].ordering = CHOLMOD_AMD;
    common_.method[1].ordering = CHOLMOD_METIS;
    common_.nrelax[0] = 8;
    common_.nrelax[1] = 24;
    common_.nrelax[2] = 64;
    common_.zrelax[0] = 0.9;
    common_.zrelax[1] = 0.3;
    common_.zrelax[2] = 0.1;
  }
  ~CholmodFactor() override {
    release();
    cholmod_finish(&common_);
  }
  CholmodFactor(const CholmodFactor&) = delete;
  CholmodFactor& operator=(const CholmodFactor&) = delete;

  void analyze(const SymmetricPattern& pattern) override {
    release();
    pattern_ = pattern;
    matrix_ = {};
    matrix_.nrow = matrix_.ncol = pattern_.size;
    matrix_.nzmax = pattern_.row.size();
    matrix_.p = pattern_.column_start.data();
    matrix_.i = pattern_.row.data();
    matrix_.stype = -1;
    matrix_.itype = CHOLMOD_INT;
    matrix_.xtype = CHOLMOD_PATTERN;
    matrix_.dtype = CHOLMOD_DOUBLE;
    matrix_.sorted = matrix_.packed = 1;
    if (pattern_.size == 0) return;
    const OneThread scope;
    const std::lock_guard lock(metis_mutex());
    factor_ = cholmod_analyze(&matrix_, &common_);
    flops_ = common_.fl;
  }

  [[nodiscard]] FactorStatus factorize(const double* values) override {
    if (pattern_.size == 0) return FactorStatus::ok;
    if (factor_ == nullptr) return FactorStatus::out_of_memory;
    const OneThread scope;
    matrix_.xtype = CHOLMOD_REAL;
    matrix_.x = const_cast<double*>(values);  // CHOLMOD only reads it
    cholmod_factorize(&matrix_, factor_, &common_);
    matrix_.x = nullptr;
    if (common_.status < 0) return FactorStatus::out_of_memory;
    if (common_.status == CHOLMOD_OK && pivots_hold(values)) return FactorStatus::ok;
    const bool finite = std::all_of(values, values + pattern_.row.size(),
                                    [](double value) { return std::isfinite(value); });
    return finite ? FactorStatus::not_positive_definite : FactorStatus::not_finite;
  }

  void solve(const double* right_sides, double* solutions, int count) override {
    const int size = pattern_.size;
    if (size == 0) return;
    const OneThread scope;
    cholmod_dense b = {};
    b.nrow = b.d = size;
    b.ncol = count;
    b.nzmax = b.nrow * b.ncol;
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    b.x = const_cast<double*>(right_sides);  // CHOLMOD only reads it
    cholmod_solve2(CHOLMOD_A, factor_, &b, nullptr, &solution_, nullptr, &scratch_y_, &scratch_e_,
                   &common_);
    std::copy_n(static_cast<const double*>(solution_->x), b.nzmax, solutions);
  }

  FactorCost cost() const override {
    if (factor_ == nullptr) return {};
    const std::size_t to_come = factor_->x == nullptr ? sizeof(double) * factor_->xsize : 0;
    return {flops_, static_cast<double>(factor_->xsize), common_.memory_inuse + to_come};
  }

 private:
  /// The BLAS lets NaN through and accepts any pivot above zero.
  bool pivots_hold(const double* values) const {
    const int* super = static_cast<const int*>(factor_->super);
    const int* row_start = static_cast<const int*>(factor_->pi);
    const int* value_start = static_cast<const int*>(factor_->px);
    const int* order = static_cast<const int*>(factor_->Perm);
    const double* x = static_cast<const double*>(factor_->x);
    for (std::size_t s = 0; s < factor_->nsuper; ++s) {
      const std::size_t height = row_start[s + 1] - row_start[s];
      for (int c = super[s]; c < super[s + 1]; ++c) {
        const double pivot = x[value_start[s] + (c - super[s]) * (height + 1)];
        const double diagonal = values[pattern_.column_start[order[c]]];
        if (!(pivot * pivot > kTinyPivot * diagonal) || !std::isfinite(pivot)) return false;
      }
    }
    return true;
  }

  void release() {
    cholmod_free_dense(&solution_, &common_);
    cholmod_free_dense(&scratch_y_, &common_);
    cholmod_free_dense(&scratch_e_, &common_);
    cholmod_free_factor(&factor_, &common_);
  }

  cholmod_common common_ = {};
  cholmod_sparse matrix_ = {};
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* solution_ = nullptr;
  cholmod_dense* scratch_y_ = nullptr;
  cholmod_dense* scratch_e_ = nullptr;
  SymmetricPattern pattern_;
  double flops_ = 0.0;
};

}  // namespace

std::unique_ptr<SparseFactor> make_cholmod_factor() {
  return std::make_unique<CholmodFactor>();
}

}  // namespace tenter::mechanics
