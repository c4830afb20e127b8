// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-worker: runs one job in a process of its own. Started by tenterd.
#include "server/jobs/results/run_job.h"
#include "server/jobs/worker/worker_main.h"

int main(int argc, char** argv) {
  return tenter::jobs::worker_main(argc, argv, tenter::jobs::run_job);
}
