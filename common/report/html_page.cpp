// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_page.h"

#include <cstdint>
#include <cstdlib>

#include "common/base/sha256.h"
#include "common/report/html_text.h"

namespace tenter::report {

namespace {

constexpr std::string_view kStyle = R"css(
:root {
  color-scheme: light dark;
  --page: #f7f7f5; --card: #ffffff; --ink: #1c2127; --soft: #5d6672; --rule: #e2e3e0; --fill: #eff0ee;
  --measured: #4a5562; --baseline: #c07a2b; --extended: #1f66ad; --outlier: #b3261e; --band: #1f66ad14;
  --good: #2b7a4b; --warn: #9a6700; --bad: #b3261e; --sensor: #7a4fa3; --plain: #5d6672;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #14171b; --card: #1b1f24; --ink: #e6e8ea; --soft: #9aa3ad; --rule: #2d333a; --fill: #242a31;
    --measured: #b3bcc6; --baseline: #dc9a4c; --extended: #67a9e8; --outlier: #ef7d75; --band: #67a9e81f;
    --good: #62b884; --warn: #d9a441; --bad: #ef7d75; --sensor: #b794dc; --plain: #9aa3ad;
  }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif; }
main { max-width: 1200px; margin: 0 auto; padding: 16px 24px 64px; }
h1 { font-size: 24px; line-height: 1.25; font-weight: 650; letter-spacing: -0.01em; margin: 2px 0 6px; text-wrap: balance; }
h2 { font-size: 18px; font-weight: 650; margin: 30px 0 9px; }
h3 { font-size: 15px; font-weight: 600; margin: 22px 0 8px; }
p { margin: 2px 0; max-width: 78ch; }
code { font: 12.5px/1.4 ui-monospace, "DejaVu Sans Mono", monospace; color: var(--soft); overflow-wrap: anywhere; }
.over, .soft { color: var(--soft); }
.over { font-size: 13px; }
nav { display: flex; flex-wrap: wrap; gap: 4px 18px; font-size: 13px; margin-top: 8px; }
a { color: var(--extended); text-decoration: none; }
a:hover { text-decoration: underline; }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(235px, 1fr)); gap: 12px; margin: 14px 0 12px; }
.card { background: var(--card); border: 1px solid var(--rule); border-radius: 8px; padding: 8px 14px 9px; }
.card .name { color: var(--soft); font-size: 13px; }
.card .value { font-size: 23px; font-weight: 600; font-variant-numeric: tabular-nums; white-space: nowrap; }
.card .value .from { color: var(--soft); font-weight: 400; font-size: 17px; }
.card .note { color: var(--soft); font-size: 12.5px; }
section > p + .panel { margin-top: 10px; }
.panel { background: var(--card); border: 1px solid var(--rule); border-radius: 8px; overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 14px; }
th { text-align: left; font-weight: 600; font-size: 12.5px; color: var(--soft); padding: 9px 12px 7px; vertical-align: bottom;
  border-bottom: 1px solid var(--rule); }
td { padding: 6px 12px 7px; vertical-align: top; border-bottom: 1px solid var(--rule); }
tr:last-child > td { border-bottom: 0; }
th.n, td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
td.wide { width: 50%; }
th.size { width: 190px; }
#verdicts p { max-width: 88ch; }
.badge { display: inline-block; font-size: 11px; font-weight: 650; letter-spacing: .04em; line-height: 1; padding: 4px 7px;
  border-radius: 4px; border: 1px solid currentColor; white-space: nowrap; color: var(--plain); }
.badge.good { color: var(--good); } .badge.warn { color: var(--warn); } .badge.bad { color: var(--bad); }
.badge.sensor { color: var(--sensor); } .badge.named { color: var(--card); background: var(--extended); border-color: var(--extended); }
.badge.synthetic { color: var(--card); background: var(--sensor); border-color: var(--sensor); }
.cause { font-weight: 600; }
.next { border-left: 3px solid var(--rule); padding-left: 10px; margin-top: 5px; }
details ol { margin: 2px 0 0; padding-left: 20px; }
ul.findings { list-style: none; margin: 4px 0; padding: 0; columns: 2; column-gap: 28px; }
ul.findings li { break-inside: avoid; margin: 0 0 10px; }
details { font-size: 13px; margin-top: 1px; }
summary { cursor: pointer; color: var(--soft); }
dl { display: grid; grid-template-columns: max-content auto; gap: 1px 16px; margin: 4px 0; }
dt { color: var(--soft); } dd { margin: 0; font-variant-numeric: tabular-nums; }
.figures { margin-top: 10px; display: grid; grid-template-columns: repeat(auto-fill, minmax(min(460px, 100%), 1fr)); gap: 14px; }
figure { margin: 0; background: var(--card); border: 1px solid var(--rule); border-radius: 8px; padding: 11px 12px 10px; }
figcaption { font-size: 13.5px; font-weight: 600; display: flex; justify-content: space-between; gap: 12px; }
figcaption .readout { font-weight: 400; color: var(--soft); font-variant-numeric: tabular-nums; white-space: nowrap; }
svg.plot { display: block; width: 100%; height: auto; touch-action: none; }
svg text { fill: var(--soft); font-size: 12px; font-variant-numeric: tabular-nums; }
svg .axis-label { fill: var(--ink); font-size: 12.5px; }
svg path { fill: none; }
svg .grid { stroke: var(--rule); stroke-width: 1; }
svg .axis { stroke: var(--soft); stroke-width: 1; }
svg .band { fill: var(--band); }
svg .ribbon path, svg.ribbon path { fill: var(--extended); fill-opacity: .16; } svg .unseen { fill: var(--soft); fill-opacity: .09; }
svg.mesh { display: block; width: 100%; height: auto; }
.mesh .face { stroke: var(--card); stroke-width: .35; stroke-opacity: .5; } .mesh .bar { stroke: none; }
.mesh .arrow { stroke: var(--ink); stroke-width: .9; stroke-opacity: .8; }
.s0 { fill: #2c3a6b; } .s1 { fill: #2f5f8f; } .s2 { fill: #2b8296; } .s3 { fill: #35a08a; } .s4 { fill: #6dbb6f; }
.s5 { fill: #aacb5a; } .s6 { fill: #e2c94a; } .s7 { fill: #eba13f; } .s8 { fill: #dd6a3a; } .s9 { fill: #b8322f; }
.unmeasured { fill: var(--fill); }
svg .cursor { stroke: var(--soft); stroke-width: .7; stroke-dasharray: 2 3; pointer-events: none; }
.dot { stroke-width: 4.2; stroke-linecap: round; }
.hole { stroke: var(--card); stroke-width: 2.2; stroke-linecap: round; }
.line { stroke-width: 1.9; stroke-linejoin: round; }
.cross { stroke-width: 1.5; stroke-opacity: .75; }
.measured .dot, .measured .line { stroke: var(--measured); }
.measured .dot { stroke-opacity: .75; } .measured .line { stroke-width: 1.2; stroke-opacity: .6; }
.baseline .dot, .baseline .line { stroke: var(--baseline); } .baseline .line { stroke-dasharray: 7 4; }
.extended .dot, .extended .line { stroke: var(--extended); }
.baseline .dot, .extended .dot { stroke-width: 3.4; stroke-opacity: .8; }
.outlier path { stroke: var(--outlier); }
.plot:has(.series:hover) .series:not(:hover) { opacity: .22; }
.off { display: none; }
.keys { display: flex; flex-wrap: wrap; gap: 2px 4px; margin: 2px 0 0 52px; }
.keys button { font: inherit; font-size: 12.5px; color: var(--ink); background: none; border: 0; border-radius: 4px; padding: 2px 7px;
  display: inline-flex; align-items: center; gap: 6px; cursor: pointer; }
.keys button:hover { background: var(--fill); }
.keys button[aria-pressed="false"] { color: var(--soft); text-decoration: line-through; }
.keys svg { width: 26px; height: 12px; }
.meter { display: block; margin-top: 5px; }
.meter .track { fill: var(--fill); } .meter .full { fill: var(--extended); } .meter .old { fill: var(--baseline); }
.meter .whisker { stroke: var(--ink); stroke-width: 1.4; } .meter .limit { stroke: var(--ink); stroke-width: 1.6; }
footer { margin-top: 44px; color: var(--soft); font-size: 12.5px; }
@media print { body { background: #fff; } .figures { grid-template-columns: 1fr 1fr; } .keys button { cursor: auto; } }
)css";

// Readout of the values under the pointer, and legend keys that hide what they name. Without it the
// page is whole.
constexpr std::string_view kScript = R"js(
"use strict";
for (const figure of document.querySelectorAll("figure")) {
  const svg = figure.querySelector("svg.plot");
  const readout = figure.querySelector(".readout");
  if (!svg || !readout) continue;
  const cursor = svg.querySelector(".cursor");
  const d = svg.dataset;
  const [left, top, right, bottom] = d.box.split(" ").map(Number);
  const show = value => Number(value.toPrecision(4)).toString();
  svg.addEventListener("pointermove", event => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    if (at.x < left || at.x > right || at.y < top || at.y > bottom) return;
    const x = +d.x0 + (at.x - left) / (right - left) * (d.x1 - d.x0);
    const y = +d.y0 + (bottom - at.y) / (bottom - top) * (d.y1 - d.y0);
    const series = event.target.closest(".series title, .series");
    const name = series ? series.querySelector("title").textContent + "  " : "";
    readout.textContent = name + show(x) + ", " + show(y);
    cursor.setAttribute("d", `M${at.x} ${top}V${bottom}M${left} ${at.y}H${right}`);
  });
  svg.addEventListener("pointerleave", () => { readout.textContent = ""; cursor.setAttribute("d", ""); });
  for (const key of figure.querySelectorAll(".keys button")) {
    key.addEventListener("click", () => {
      const on = key.getAttribute("aria-pressed") === "true";
      key.setAttribute("aria-pressed", String(!on));
      for (const group of svg.querySelectorAll("." + key.dataset.shows.split(" ").join(".")))
        group.classList.toggle("off", on);
    });
  }
}
)js";

/// SHA-256 in base64, as a content policy wants it.
std::string script_hash() {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::string hex = sha256_hex(kScript);
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes += static_cast<char>(std::strtol(hex.substr(i, 2).c_str(), nullptr, 16));
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = (group << 8) | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kDigits[(group >> (18 - 6 * k)) & 63u];
  }
  return out;
}

}  // namespace

std::string html_page(std::string_view title, std::string_view body) {
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'; script-src 'sha256-";
  page += script_hash() + "'; base-uri 'none'; form-action 'none'\">\n";
  page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>";
  page += escape_html(title) + "</title>\n<style>" + std::string(kStyle) +
          "</style>\n</head>\n<body>\n<main>\n";
  page += body;
  page += "</main>\n<script>" + std::string(kScript) + "</script>\n</body>\n</html>\n";
  return page;
}

}  // namespace tenter::report
