// SPDX-License-Identifier: GPL-3.0-or-later
// The panel kernels (panel_kernels.h) in terms of a vector: included once per instruction set,
// inside a namespace that defines Vec, its operations, kLanes, kTileBlocks and kTileColumns.
//
// No #pragma once and no includes: this is a body, not a header. Loops over registers are unrolled
// by pragma, because a tile that is not in registers is worth nothing.

constexpr int kVectors = kBlock / kLanes;  // of one block

/// sum over k < depth of a[k][block rows] b[k][j]: columns of a and b are `rows` apart.
template <int Blocks, int Columns>
[[gnu::always_inline]] inline void products(const double* a, const double* b, long rows, int depth,
                                            Vec (&tile)[Blocks * kVectors][Columns]) {
#pragma GCC unroll 24
  for (int i = 0; i < Blocks * kVectors; ++i)
#pragma GCC unroll 8
    for (int j = 0; j < Columns; ++j) tile[i][j] = zero();
  for (int k = 0; k < depth; ++k, a += rows, b += rows) {
    Vec column[Blocks * kVectors];
#pragma GCC unroll 24
    for (int i = 0; i < Blocks * kVectors; ++i) column[i] = load(a + i * kLanes);
#pragma GCC unroll 8
    for (int j = 0; j < Columns; ++j) {
      const Vec factor = spread(b[j]);
#pragma GCC unroll 24
      for (int i = 0; i < Blocks * kVectors; ++i)
        tile[i][j] = multiply_add(column[i], factor, tile[i][j]);
    }
  }
}

// ---- factor: blocks of kBlock columns, each brought up to date with the columns left of it, its
// triangle factored, the rows below solved with it while they are in registers.

/// The triangle: a[j][r] is column j, row r.
template <int Columns>
[[gnu::always_inline]] inline bool factor_triangle(double (&a)[Columns][kBlock],
                                                   const double* smallest_pivot,
                                                   double* inverse_pivot) {
  for (int j = 0; j < Columns; ++j) {
    const double pivot = a[j][j];
    if (!(pivot > smallest_pivot[j]) || !(pivot <= __DBL_MAX__)) return false;
    const double root = __builtin_sqrt(pivot);
    inverse_pivot[j] = 1.0 / root;
    for (int r = 0; r < kBlock; ++r) a[j][r] = r < j ? 0.0 : a[j][r] * inverse_pivot[j];
    a[j][j] = root;
    for (int k = j + 1; k < Columns; ++k) {
      const double factor = a[j][k];
      for (int r = 0; r < kBlock; ++r) a[k][r] -= a[j][r] * factor;
    }
  }
  return true;
}

template <int Blocks, int Columns>
[[gnu::always_inline]] inline void solve_rows(double* panel, long rows, int first_column, int row,
                                              const double (&triangle)[Columns][kBlock],
                                              const double* inverse_pivot) {
  Vec tile[Blocks * kVectors][Columns];
  products<Blocks, Columns>(panel + row, panel + first_column, rows, first_column, tile);
  double* target = panel + first_column * rows + row;
#pragma GCC unroll 8
  for (int j = 0; j < Columns; ++j) {
#pragma GCC unroll 24
    for (int i = 0; i < Blocks * kVectors; ++i)
      tile[i][j] = subtract(load(target + j * rows + i * kLanes), tile[i][j]);
#pragma GCC unroll 8
    for (int k = 0; k < j; ++k) {
      const Vec factor = spread(triangle[k][j]);
#pragma GCC unroll 24
      for (int i = 0; i < Blocks * kVectors; ++i)
        tile[i][j] = multiply_subtract(tile[i][k], factor, tile[i][j]);
    }
    const Vec inverse = spread(inverse_pivot[j]);
#pragma GCC unroll 24
    for (int i = 0; i < Blocks * kVectors; ++i) {
      tile[i][j] = multiply(tile[i][j], inverse);
      store(target + j * rows + i * kLanes, tile[i][j]);
    }
  }
}

template <int Columns>
bool factor_columns(double* panel, long rows, int first, const double* smallest_pivot,
                    double* inverse_pivot) {
  alignas(64) double triangle[Columns][kBlock];
  Vec tile[kVectors][Columns];
  products<1, Columns>(panel + first, panel + first, rows, first, tile);
  double* corner = panel + first * rows + first;
#pragma GCC unroll 8
  for (int j = 0; j < Columns; ++j)
#pragma GCC unroll 4
    for (int i = 0; i < kVectors; ++i)
      store(&triangle[j][i * kLanes], subtract(load(corner + j * rows + i * kLanes), tile[i][j]));
  if (!factor_triangle<Columns>(triangle, smallest_pivot + first, inverse_pivot + first))
    return false;
  for (int j = 0; j < Columns; ++j)
    for (int i = 0; i < kVectors; ++i)
      store(corner + j * rows + i * kLanes, load(&triangle[j][i * kLanes]));

  int row = first + kBlock;
  if constexpr (kTileBlocks >= 3)
    for (; row + 4 * kBlock < rows || row + 3 * kBlock == rows; row += 3 * kBlock)
      solve_rows<3, Columns>(panel, rows, first, row, triangle, inverse_pivot + first);
  if constexpr (kTileBlocks >= 2)
    for (; row + 2 * kBlock <= rows; row += 2 * kBlock)
      solve_rows<2, Columns>(panel, rows, first, row, triangle, inverse_pivot + first);
  for (; row < rows; row += kBlock)
    solve_rows<1, Columns>(panel, rows, first, row, triangle, inverse_pivot + first);
  return true;
}

bool factor(double* panel, int rows, int width, const double* smallest_pivot,
            double* inverse_pivot) {
  for (int first = 0; first < width; first += kBlock) {
    bool ok = false;
    switch (width - first) {
      case 1:
        ok = factor_columns<1>(panel, rows, first, smallest_pivot, inverse_pivot);
        break;
      case 2:
        ok = factor_columns<2>(panel, rows, first, smallest_pivot, inverse_pivot);
        break;
      case 3:
        ok = factor_columns<3>(panel, rows, first, smallest_pivot, inverse_pivot);
        break;
      case 4:
        ok = factor_columns<4>(panel, rows, first, smallest_pivot, inverse_pivot);
        break;
      case 5:
        ok = factor_columns<5>(panel, rows, first, smallest_pivot, inverse_pivot);
        break;
      case 6:
        ok = factor_columns<6>(panel, rows, first, smallest_pivot, inverse_pivot);
        break;
      case 7:
        ok = factor_columns<7>(panel, rows, first, smallest_pivot, inverse_pivot);
        break;
      default:
        ok = factor_columns<8>(panel, rows, first, smallest_pivot, inverse_pivot);
        break;
    }
    if (!ok) return false;
  }
  return true;
}

// ---- update: tiles of L21 L21' go from registers to where they belong in the target.

template <int Blocks, int Columns>
[[gnu::always_inline]] inline void update_tile(const double* panel, long rows, int width,
                                               const PanelUpdate& where, int block, int column,
                                               double* target, long target_rows) {
  Vec tile[Blocks * kVectors][Columns];
  const double* source = panel + where.first_row;
  products<Blocks, Columns>(source + block * kBlock, source + column, rows, width, tile);
  double* to[Columns];
#pragma GCC unroll 8
  for (int j = 0; j < Columns; ++j) to[j] = target + where.column[column + j] * target_rows;
#pragma GCC unroll 3
  for (int b = 0; b < Blocks; ++b) {
    for (int r = where.run_start[block + b]; r < where.run_start[block + b + 1]; ++r) {
      const RowRun run = where.runs[r];
      if (run.rows == (1u << kBlock) - 1) {
#pragma GCC unroll 8
        for (int j = 0; j < Columns; ++j)
#pragma GCC unroll 4
          for (int i = 0; i < kVectors; ++i) {
            double* place = to[j] + run.offset + i * kLanes;
            store(place, subtract(load(place), tile[b * kVectors + i][j]));
          }
      } else {
#pragma GCC unroll 8
        for (int j = 0; j < Columns; ++j)
#pragma GCC unroll 4
          for (int i = 0; i < kVectors; ++i)
            subtract_lanes(to[j] + run.offset + i * kLanes, tile[b * kVectors + i][j],
                           (run.rows >> (i * kLanes)) & ((1u << kLanes) - 1));
      }
    }
  }
}

template <int Columns>
void update_columns(const double* panel, long rows, int width, const PanelUpdate& where, int column,
                    double* target, long target_rows) {
  int block = column / kBlock;
  if constexpr (kTileBlocks >= 3)
    for (; where.blocks - block > 4 || where.blocks - block == 3; block += 3)
      update_tile<3, Columns>(panel, rows, width, where, block, column, target, target_rows);
  if constexpr (kTileBlocks >= 2)
    for (; where.blocks - block >= 2; block += 2)
      update_tile<2, Columns>(panel, rows, width, where, block, column, target, target_rows);
  for (; block < where.blocks; ++block)
    update_tile<1, Columns>(panel, rows, width, where, block, column, target, target_rows);
}

void update(const double* panel, int rows, int width, const PanelUpdate& where, double* target,
            int target_rows) {
  int tiles = (where.columns + kTileColumns - 1) / kTileColumns;
  for (int column = 0; tiles > 0; --tiles) {
    const int columns = (where.columns - column + tiles - 1) / tiles;
    const auto run = [&]<int Columns>() {
      if constexpr (Columns <= kTileColumns)
        update_columns<Columns>(panel, rows, width, where, column, target, target_rows);
    };
    switch (columns) {
      case 1:
        run.template operator()<1>();
        break;
      case 2:
        run.template operator()<2>();
        break;
      case 3:
        run.template operator()<3>();
        break;
      case 4:
        run.template operator()<4>();
        break;
      case 5:
        run.template operator()<5>();
        break;
      case 6:
        run.template operator()<6>();
        break;
      case 7:
        run.template operator()<7>();
        break;
      default:
        run.template operator()<8>();
        break;
    }
    column += columns;
  }
}

// ---- solves

void forward(const double* panel, int rows, int width, const double* inverse_pivot, double* x) {
  for (int first = 0; first < width; first += kBlock) {
    const int columns = width - first < kBlock ? width - first : kBlock;
    const double* corner = panel + static_cast<long>(first) * rows + first;
    double z[kBlock] = {};
    for (int j = 0; j < columns; ++j) {
      z[j] = x[first + j] * inverse_pivot[first + j];
      for (int r = j + 1; r < kBlock; ++r)
        x[first + r] -= corner[j * static_cast<long>(rows) + r] * z[j];
      x[first + j] = z[j];
    }
    for (int row = first + kBlock; row < rows; row += kLanes) {
      Vec part = load(x + row);
      const double* entry = panel + static_cast<long>(first) * rows + row;
      if (columns == kBlock) {
#pragma GCC unroll 8
        for (int j = 0; j < kBlock; ++j)
          part = multiply_subtract(load(entry + static_cast<long>(j) * rows), spread(z[j]), part);
      } else {
        for (int j = 0; j < columns; ++j)
          part = multiply_subtract(load(entry + static_cast<long>(j) * rows), spread(z[j]), part);
      }
      store(x + row, part);
    }
  }
}

void backward(const double* panel, int rows, int width, const double* inverse_pivot, double* x) {
  for (int first = (width - 1) / kBlock * kBlock; first >= 0; first -= kBlock) {
    const int columns = width - first < kBlock ? width - first : kBlock;
    const double* corner = panel + static_cast<long>(first) * rows + first;
    Vec total[kBlock];
    for (int j = 0; j < kBlock; ++j) total[j] = zero();
    for (int row = kBlock; row < rows - first; row += kLanes) {
      const Vec part = load(x + first + row);
      if (columns == kBlock) {
#pragma GCC unroll 8
        for (int j = 0; j < kBlock; ++j)
          total[j] = multiply_add(load(corner + static_cast<long>(j) * rows + row), part, total[j]);
      } else {
        for (int j = 0; j < columns; ++j)
          total[j] = multiply_add(load(corner + static_cast<long>(j) * rows + row), part, total[j]);
      }
    }
    for (int j = columns - 1; j >= 0; --j) {
      double value = x[first + j] - sum(total[j]);
      for (int r = j + 1; r < kBlock; ++r)
        value -= corner[static_cast<long>(j) * rows + r] * x[first + r];
      x[first + j] = value * inverse_pivot[first + j];
    }
  }
}

/// The right-hand sides of one row.
[[gnu::always_inline]] inline void subtract_scaled(double* x, const double* y, double factor) {
#pragma GCC unroll 4
  for (int i = 0; i < kVectors; ++i)
    store(x + i * kLanes,
          multiply_subtract(load(y + i * kLanes), spread(factor), load(x + i * kLanes)));
}

[[gnu::always_inline]] inline void scale(double* x, double factor) {
#pragma GCC unroll 4
  for (int i = 0; i < kVectors; ++i)
    store(x + i * kLanes, multiply(load(x + i * kLanes), spread(factor)));
}

void forward_block(const double* panel, int rows, int width, const double* inverse_pivot,
                   double* x) {
  for (int first = 0; first < width; first += kBlock) {
    const int columns = width - first < kBlock ? width - first : kBlock;
    const double* corner = panel + static_cast<long>(first) * rows + first;
    double* top = x + first * kBlock;
    for (int j = 0; j < columns; ++j) {
      scale(top + j * kBlock, inverse_pivot[first + j]);
      for (int r = j + 1; r < kBlock; ++r)
        subtract_scaled(top + r * kBlock, top + j * kBlock,
                        corner[static_cast<long>(j) * rows + r]);
    }
    for (int row = kBlock; row < rows - first; row += kBlock) {
#pragma GCC unroll 4
      for (int i = 0; i < kVectors; ++i) {
        Vec part[kBlock];
#pragma GCC unroll 8
        for (int r = 0; r < kBlock; ++r) part[r] = load(top + (row + r) * kBlock + i * kLanes);
        for (int j = 0; j < columns; ++j) {
          const Vec known = load(top + j * kBlock + i * kLanes);
          const double* entry = corner + static_cast<long>(j) * rows + row;
#pragma GCC unroll 8
          for (int r = 0; r < kBlock; ++r)
            part[r] = multiply_subtract(spread(entry[r]), known, part[r]);
        }
#pragma GCC unroll 8
        for (int r = 0; r < kBlock; ++r) store(top + (row + r) * kBlock + i * kLanes, part[r]);
      }
    }
  }
}

void backward_block(const double* panel, int rows, int width, const double* inverse_pivot,
                    double* x) {
  for (int first = (width - 1) / kBlock * kBlock; first >= 0; first -= kBlock) {
    const int columns = width - first < kBlock ? width - first : kBlock;
    const double* corner = panel + static_cast<long>(first) * rows + first;
    double* top = x + first * kBlock;
#pragma GCC unroll 4
    for (int i = 0; i < kVectors; ++i) {
      Vec part[kBlock];
#pragma GCC unroll 8
      for (int j = 0; j < kBlock; ++j) part[j] = load(top + j * kBlock + i * kLanes);
      for (int row = kBlock; row < rows - first; ++row) {
        const Vec known = load(top + row * kBlock + i * kLanes);
        if (columns == kBlock) {
#pragma GCC unroll 8
          for (int j = 0; j < kBlock; ++j)
            part[j] = multiply_subtract(spread(corner[static_cast<long>(j) * rows + row]), known,
                                        part[j]);
        } else {
#pragma GCC unroll 8
          for (int j = 0; j < kBlock; ++j)
            if (j < columns)
              part[j] = multiply_subtract(spread(corner[static_cast<long>(j) * rows + row]), known,
                                          part[j]);
        }
      }
#pragma GCC unroll 8
      for (int j = 0; j < kBlock; ++j)
        if (j < columns) store(top + j * kBlock + i * kLanes, part[j]);
    }
    for (int j = columns - 1; j >= 0; --j) {
      for (int r = j + 1; r < kBlock; ++r)
        subtract_scaled(top + j * kBlock, top + r * kBlock,
                        corner[static_cast<long>(j) * rows + r]);
      scale(top + j * kBlock, inverse_pivot[first + j]);
    }
  }
}
