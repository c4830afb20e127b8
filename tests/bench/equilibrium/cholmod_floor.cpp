// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/equilibrium/cholmod_floor.h"

#include <cholmod.h>

#include <algorithm>

#include "common/base/one_thread.h"

extern "C" __attribute__((weak)) void openblas_set_num_threads(int count);

namespace tenter::mechanics::bench {

namespace {

class CholmodFloor final : public SparseFactor {
 public:
  CholmodFloor(Ordering ordering, Relaxation relaxation) {
    if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.nmethods = 1;
    common_.method[0].ordering = ordering == Ordering::amd ? CHOLMOD_AMD : CHOLMOD_METIS;
    if (relaxation == Relaxation::wide) {
      const std::size_t columns[] = {8, 24, 64};
      const double zeros[] = {0.9, 0.3, 0.1};
      std::copy_n(columns, 3, common_.nrelax);
      std::copy_n(zeros, 3, common_.zrelax);
    }
  }
  ~CholmodFloor() override {
    cholmod_free_dense(&solution_, &common_);
    cholmod_free_dense(&scratch_y_, &common_);
    cholmod_free_dense(&scratch_e_, &common_);
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  CholmodFloor(const CholmodFloor&) = delete;
  CholmodFloor& operator=(const CholmodFloor&) = delete;

  void analyze(const SymmetricPattern& pattern) override {
    pattern_ = pattern;
    matrix_.nrow = matrix_.ncol = pattern_.size;
    matrix_.nzmax = pattern_.row.size();
    matrix_.p = pattern_.column_start.data();
    matrix_.i = pattern_.row.data();
    matrix_.stype = -1;
    matrix_.itype = CHOLMOD_INT;
    matrix_.xtype = CHOLMOD_PATTERN;
    matrix_.dtype = CHOLMOD_DOUBLE;
    matrix_.sorted = matrix_.packed = 1;
    factor_ = cholmod_analyze(&matrix_, &common_);
    flops_ = common_.fl;
  }

  [[nodiscard]] FactorStatus factorize(const double* values) override {
    matrix_.xtype = CHOLMOD_REAL;
    matrix_.x = const_cast<double*>(values);
    cholmod_factorize(&matrix_, factor_, &common_);
    return common_.status == CHOLMOD_OK ? FactorStatus::ok : FactorStatus::not_positive_definite;
  }

  void solve(const double* right_sides, double* solutions, int count) override {
    cholmod_dense b = {};
    b.nrow = b.d = pattern_.size;
    b.ncol = count;
    b.nzmax = b.nrow * b.ncol;
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    b.x = const_cast<double*>(right_sides);
    cholmod_solve2(CHOLMOD_A, factor_, &b, nullptr, &solution_, nullptr, &scratch_y_, &scratch_e_,
                   &common_);
    std::copy_n(static_cast<const double*>(solution_->x), b.nzmax, solutions);
  }

  FactorCost cost() const override {
    return {flops_, static_cast<double>(factor_->xsize), common_.memory_inuse};
  }

 private:
  OneThread one_thread_;
  cholmod_common common_ = {};
  cholmod_sparse matrix_ = {};
  cholmod_factor* factor_ = nullptr;
  cholmod_dense *solution_ = nullptr, *scratch_y_ = nullptr, *scratch_e_ = nullptr;
  SymmetricPattern pattern_;
  double flops_ = 0.0;
};

}  // namespace

std::unique_ptr<SparseFactor> make_cholmod_floor(Ordering ordering, Relaxation relaxation) {
  return std::make_unique<CholmodFloor>(ordering, relaxation);
}

}  // namespace tenter::mechanics::bench
