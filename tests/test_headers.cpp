// SPDX-License-Identifier: GPL-3.0-or-later
// The headers that the tests share are read with the options of this file.
