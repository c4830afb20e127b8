// SPDX-License-Identifier: GPL-3.0-or-later
// The dense work of the supernodal factorisation and solves, once per instruction set; which one
// runs is chosen when the program runs.
//
// A panel is the part of L that belongs to one supernode: `width` columns of `rows` scalars, column
// after column, where rows is the supernode's height rounded up to kBlock; the rows of the padding
// are zero and stay zero. The first `width` rows are the triangle on the diagonal, zero above it
// once factored. Panels start on 64 bytes.
//
// Arithmetic happens in a fixed order, so the same panel gives the same bytes; two instruction sets
// agree to rounding. Nothing here allocates or is shared between threads.
#pragma once

#include <vector>

namespace tenter::mechanics {

constexpr int kBlock = 8;  ///< rows are handled in blocks of so many

/// Rows of a block that stay together in the target: row r of the block, where bit r of rows is
/// set, is row offset + r of the target panel.
struct RowRun {
  int offset = 0;
  unsigned rows = 0;
};

/// Where the rows of a panel from `first_row` on lie in the panel that the first `columns` of them
/// are columns of.
struct PanelUpdate {
  int target = 0;                  ///< supernode
  int first_row = 0;               ///< in the source panel
  int columns = 0;                 ///< rows first_row .. + columns are columns of the target
  int blocks = 0;                  ///< of kBlock rows, from first_row to the last row
  const int* column = nullptr;     ///< [columns] column of the target panel
  const int* run_start = nullptr;  ///< [blocks + 1] into runs
  const RowRun* runs = nullptr;
};

struct PanelKernels {
  const char* name;

  /// Cholesky of the panel's triangle and L21 = A21 L11^-T below it. Writes 1 / pivot of every
  /// column. False when a pivot is not finite or not above smallest_pivot[column].
  bool (*factor)(double* panel, int rows, int width, const double* smallest_pivot,
                 double* inverse_pivot);

  /// target -= L21 L21' of the columns and rows of the update.
  void (*update)(const double* panel, int rows, int width, const PanelUpdate& where, double* target,
                 int target_rows);

  /// x1 = L11^-1 x1, x2 -= L21 x1 for x = (x1, x2) of `rows` numbers.
  void (*forward)(const double* panel, int rows, int width, const double* inverse_pivot, double* x);
  /// x1 = L11^-T (x1 - L21' x2).
  void (*backward)(const double* panel, int rows, int width, const double* inverse_pivot,
                   double* x);
  /// The same for kBlock right-hand sides at a time: x has kBlock numbers a row.
  void (*forward_block)(const double* panel, int rows, int width, const double* inverse_pivot,
                        double* x);
  void (*backward_block)(const double* panel, int rows, int width, const double* inverse_pivot,
                         double* x);
};

extern const PanelKernels kPortableKernels;  ///< any x86-64, SSE2
extern const PanelKernels kAvx2Kernels;      ///< needs AVX2 and FMA
extern const PanelKernels kAvx512Kernels;    ///< needs AVX-512 F and DQ

/// Those that this processor can run, best first.
std::vector<const PanelKernels*> runnable_panel_kernels();

}  // namespace tenter::mechanics
