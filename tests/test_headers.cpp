// SPDX-License-Identifier: Apache-2.0
// The headers that the tests share are read with the options of this file.
