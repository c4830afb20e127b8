// SPDX-License-Identifier: Apache-2.0
#include "client/cli/app.h"

int main(int argc, char** argv) {
  return tenter::cli::run(argc, argv);
}
