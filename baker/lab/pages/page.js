/* Parts of all pages: elements, tables, numbers as text.
 *
 * Texts of scenes, lights and files are untrusted. They become text nodes and attributes, never markup.
 * SPDX-License-Identifier: GPL-3.0-or-later */
"use strict";

const data = JSON.parse(document.getElementById("data").textContent);
const NO_BREAK = "\u00a0", THIN = "\u202f"; /* blanks that do not break a line */

/* elements --------------------------------------------------------------------------------------------------------------------- */

/* Control characters, those that change the direction of text, and invalid characters become '?'. */
function clean(text) {
    return String(text).replace(/[\p{Cc}\p{Cs}\u2028-\u202e\u2066-\u2069\ufdd0-\ufdef\ufffe\uffff]/gu, "?");
}

function el(tag, attributes, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    element.append(...children.flat());
    return element;
}

function show(...elements) {
    document.body.append(...elements);
}

const soft = (...children) => el("p", { class: "soft" }, ...children);
const list = (items) => el("ul", {}, ...items.map((item) => el("li", {}, item)));
const key = (...items) => el("ul", { class: "key" }, ...items.map((item) => el("li", {}, ...item)));
const swatch = (colour) => el("i", { style: `background: ${colour}` });

/* A key figure at the head of a page. */
const fact = (question, answer, about) => el("div", {}, el("small", {}, question), el("b", {}, answer), el("small", {}, about));

/* Cells that are not numbers. */
const text = (...words) => el("td", { class: "text" }, ...words);
const long = (words) => el("td", { class: "long" }, words);
const bar = (share, style = "") => el("td", { class: "bar" }, el("i", { style: `width: ${100 * share || 0}%; ${style}` }));

/* rows  lists of cells: a text, a list of texts and elements, or a td. A heading is aligned as the cells below it. */
function table(heads, rows, foot) {
    const cell = (content) => content instanceof HTMLTableCellElement ? content : el("td", {}, ...[content].flat());
    const row = (cells) => el("tr", {}, ...cells.map(cell));
    const body = el("tbody", {}, ...rows.map(row)), parts = [body];
    const th = (head, n) => el("th", { class: body.firstChild ? body.firstChild.cells[n].className : "" }, head);
    if (heads) parts.unshift(el("thead", {}, el("tr", {}, ...heads.map(th))));
    if (foot) parts.push(el("tfoot", {}, row(foot)));
    return el("div", { class: "table" }, el("table", {}, ...parts));
}

/* figures ---------------------------------------------------------------------------------------------------------------------- */

/* Three significant digits, without an exponent. */
function digits(value) {
    const before = value >= 1 ? Math.floor(Math.log10(value)) + 1 : 1;
    const small = value > 0 && value < 0.1;
    const shown = value.toFixed(small ? Math.min(6, 1 - Math.floor(Math.log10(value))) : Math.max(0, 3 - before));
    return shown.includes(".") ? shown.replace(/\.?0+$/, "") : shown;
}

function seconds(value) {
    const units = [[36000, 3600, "h"], [600, 60, "min"], [0.9995, 1, "s"], [0.9995e-3, 1e-3, "ms"], [0.9995e-6, 1e-6, "µs"],
        [0, 1e-9, "ns"]];
    const [, unit, name] = units.find(([from]) => value >= from);
    return value > 0 ? digits(value / unit) + NO_BREAK + name : "0";
}

const nanoseconds = (value) => seconds(value * 1e-9);
const percent = (share) => digits(100 * share) + NO_BREAK + "%";

/* As in reports as text. */
function bytes(value) {
    if (value < 10 * 1024) return Math.floor(value) + NO_BREAK + "B";
    const unit = [1, 2, 3].find((power) => value / 1024 ** power < 1023.95) ?? 4, size = value / 1024 ** unit;
    return size.toFixed(size < 9.995 ? 2 : 1) + NO_BREAK + ["KiB", "MiB", "GiB", "TiB"][unit - 1];
}

function count(value) {
    const shown = value.toFixed(0);
    return shown.length > 4 ? shown.replace(/\B(?=(\d{3})+$)/g, THIN) : shown;
}

const significant = (value, precision = 3) => String(Number(value.toPrecision(precision)));
const sum = (items, value) => items.reduce((total, item) => total + value(item), 0);
const plural = (number, word) => `${number} ${word}${number === 1 ? "" : "s"}`;
const base_name = (path) => clean(path.replace(/.*\/(?=.)/s, ""));

/* levels: 0 masks, n nodes of 2^n voxels a side -------------------------------------------------------------------------------- */

const level_name = (level) => level ? `${2 ** level}³` : "masks";

/* Masks have a colour of their own, nodes fade from fine to coarse. */
function level_colour(level) {
    const shade = Math.min(1, Math.max(0, (level - 3) / 8));
    return level ? `rgb(${0x24 + shade * 0xa4 | 0}, ${0x54 + shade * 0x84 | 0}, ${0x8c + shade * 0x5c | 0})` : "#d0702a";
}
