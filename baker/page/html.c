/* A page that stands alone; see html.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/html.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "baker/files/png_encode.h"
#include "baker/base/text.h"

/* style ----------------------------------------------------------------------------------------------------------------------- */

/* Paper and ink change with the reader's wish; pictures and the colours of series stay. */
/* clang-format off */
static const char style[] =
    ":root{color-scheme:light dark;--paper:#fffefa;--ink:#22221f;--soft:#66645d;--rule:#dcd9cf;--bar:#c9d5e3;--actual:#3d7ab8}\n"
    "@media screen and (prefers-color-scheme:dark){:root{--paper:#17181a;--ink:#e6e3db;--soft:#a5a196;--rule:#3b3c3f;--bar:#33475c;"
        "--actual:#6ea4dc}}\n"
    "*{box-sizing:border-box}\n"
    "body{margin:0 auto;max-width:70rem;padding:2rem 1.25rem 4rem;background:var(--paper);color:var(--ink);overflow-wrap:anywhere;"
        "font:16px/1.5 system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif}\n"
    "h1{font-size:1.7rem;line-height:1.2;font-weight:600;margin:0 0 .3rem}\n"
    "h2{font-size:1.2rem;line-height:1.3;font-weight:600;margin:2.6rem 0 .5rem;padding-top:.7rem;border-top:1px solid var(--rule)}\n"
    "h3{font-size:1rem;line-height:1.35;font-weight:600;margin:1.2rem 0 .3rem}\n"
    "p,ul{margin:.3rem 0 .7rem;max-width:46rem}ul{padding-left:1.2rem}li{margin:.25rem 0}\n"
    ".soft,figcaption,small{color:var(--soft)}small,figcaption{font-size:.85rem}\n"
    ".facts{display:flex;flex-wrap:wrap;gap:.8rem 2.2rem;margin:1.2rem 0}\n"
    ".facts b{display:block;font-size:1.35rem;line-height:1.25;font-weight:500}\n"
    ".plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,27rem),1fr));gap:1.4rem 2.2rem}\n"
    ".pairs{display:grid;grid-template-columns:minmax(0,1fr) minmax(0,1fr);gap:.8rem 1.2rem;margin:.5rem 0}\n"
    "figure{margin:0;break-inside:avoid;min-width:0}figure h3{margin:.3rem 0}figcaption{margin:.3rem 0 0}\n"
    "svg{display:block;width:100%;height:auto;max-width:44rem}\n"
    ".span{grid-column:1/-1}.span div{overflow-x:auto}.span svg{min-width:38rem;max-width:47.5rem}\n"
    "img{display:block;width:100%;height:auto;border:1px solid var(--rule)}.few{image-rendering:pixelated}\n"
    ".table{overflow-x:auto;margin:.5rem 0 1rem}\n"
    "table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums;overflow-wrap:normal}\n"
    "th,td{padding:.22rem .9rem .22rem 0;text-align:right;vertical-align:baseline;white-space:nowrap}\n"
    "th{font-weight:500;color:var(--soft);border-bottom:1px solid var(--rule)}tfoot td{border-top:1px solid var(--rule)}\n"
    ".text,th.text{text-align:left}.long{white-space:normal;min-width:14rem;text-align:left;overflow-wrap:anywhere}\n"
    "td.bar{width:12rem;min-width:7rem}td.bar i{display:block;height:.75rem;background:var(--actual);min-width:1px}\n"
    "td.bar u{display:block;height:.25rem;background:var(--bar);min-width:1px;margin-top:1px}\n"
    ".stack{display:flex;height:1.5rem;margin:.4rem 0;max-width:46rem}.stack i{display:block;min-width:0}\n"
    ".key{display:flex;flex-wrap:wrap;gap:.2rem 1.1rem;margin:.3rem 0 .8rem;font-size:.85rem}\n"
    ".key i{display:inline-block;width:.85rem;height:.85rem;margin-right:.4rem;vertical-align:-.08rem;outline:1px solid var(--rule)}\n"
    "@media print{html{font-size:11px}body{padding:0;max-width:none;font-size:1rem}tfoot{display:table-row-group}\n"
        "h2{break-after:avoid}tr{break-inside:avoid}"
        ".table{overflow:visible}.table table{font-size:.7rem}th,td{padding-right:.5rem}.plots{grid-template-columns:1fr 1fr}"
        ".span svg{min-width:0}i,u{print-color-adjust:exact;-webkit-print-color-adjust:exact}}\n";
/* clang-format on */

void html_begin(FILE *to, const char *title)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:\">\n"
          "<title>",
          to);
    html_text(to, title);
    fprintf(to, "</title>\n<style>\n%s</style>\n</head>\n<body>\n", style);
}

void html_end(FILE *to)
{
    fputs("</body>\n</html>\n", to);
}

/* text ------------------------------------------------------------------------------------------------------------------------ */

/* Bytes of the character at c when it is one that any text may hold, else 0. */
static size_t character_bytes(const unsigned char *c)
{
    static const uint32_t least[] = {0, 0x20, 0x80, 0x800, 0x10000};
    size_t                bytes   = c[0] < 0x80 ? 1 : c[0] >= 0xf0 ? 4 : c[0] >= 0xe0 ? 3 : c[0] >= 0xc0 ? 2 : 0;
    uint32_t              code    = bytes == 1 ? c[0] : bytes ? c[0] & (0xffu >> (bytes + 1)) : 0;
    for (size_t n = 1; n < bytes; n++) {
        if ((c[n] & 0xc0) != 0x80) return 0; /* the end of the text, too */
        code = code << 6 | (c[n] & 0x3f);
    }
    int control = code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x2028 || code == 0x2029;
    int turning = (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069); /* the order of what follows */
    int nothing = (code >= 0xd800 && code < 0xe000) || (code >= 0xfdd0 && code < 0xfdf0) || (code & 0xfffe) == 0xfffe;
    return !bytes || code < least[bytes] || code > 0x10ffff || control || turning || nothing ? 0 : bytes;
}

char *clean_text(char *text)
{
    unsigned char *to = (unsigned char *)text;
    for (const unsigned char *from = to; *from;) {
        size_t bytes = character_bytes(from);
        if (!bytes) *to++ = '?', from++;
        while (bytes--) *to++ = *from++;
    }
    *to = 0;
    return text;
}

void html_text(FILE *to, const char *text)
{
    for (const unsigned char *c = (const unsigned char *)text; *c;) {
        size_t bytes = character_bytes(c);
        switch (bytes ? *c : 0) {
        case 0: fputc('?', to); break;
        case '<': fputs("&lt;", to); break;
        case '>': fputs("&gt;", to); break;
        case '&': fputs("&amp;", to); break;
        case '"': fputs("&quot;", to); break;
        case '\'': fputs("&#39;", to); break;
        default: fwrite(c, 1, bytes, to);
        }
        c += bytes ? bytes : 1;
    }
}

void html_textf(FILE *to, const char *format, ...)
{
    char    text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    html_text(to, text);
}

/* figures --------------------------------------------------------------------------------------------------------------------- */

/* Three digits that count, without an exponent. */
static void three_digits(char text[32], double value)
{
    int before = value >= 1 ? (int)floor(log10(value)) + 1 : 1;
    int after  = before < 3 ? 3 - before : 0;
    if (value > 0 && value < 0.1) after = (int)fmin(6, 1 - floor(log10(value)));
    snprintf(text, 32, "%.*f", after, value);
    if (strchr(text, '.')) {
        char *end = text + strlen(text);
        while (end[-1] == '0') *--end = 0;
        if (end[-1] == '.') end[-1] = 0;
    }
}

#define SPACE "\xc2\xa0"     /* does not break */
#define THIN  "\xe2\x80\xaf" /* nor does this one */

const char *seconds_text(char text[32], double seconds)
{
    static const struct {
        double      from, unit;
        const char *name;
    } units[] = {{3600 * 10, 3600, "h"}, {600, 60, "min"}, {0.9995, 1, "s"}, {0.9995e-3, 1e-3, "ms"}, {0.9995e-6, 1e-6, "µs"}};
    char number[32];
    for (size_t n = 0; n < sizeof units / sizeof *units; n++)
        if (seconds >= units[n].from) {
            three_digits(number, seconds / units[n].unit);
            snprintf(text, 32, "%.20s" SPACE "%s", number, units[n].name);
            return text;
        }
    three_digits(number, seconds * 1e9);
    snprintf(text, 32, seconds > 0 ? "%.20s" SPACE "ns" : "%.20s", number);
    return text;
}

const char *percent_text(char text[32], double share)
{
    char number[32];
    three_digits(number, 100 * share);
    snprintf(text, 32, "%.20s" SPACE "%%", number);
    return text;
}

void html_bytes(FILE *to, double bytes)
{
    char   text[32];
    size_t number = strcspn(size_text(text, (uint64_t)bytes), " ");
    fprintf(to, "%.*s" SPACE "%s", (int)number, text, text + number + 1);
}

void html_seconds(FILE *to, double seconds)
{
    char text[32];
    fputs(seconds_text(text, seconds), to);
}

void html_percent(FILE *to, double share)
{
    char text[32];
    fputs(percent_text(text, share), to);
}

void html_count(FILE *to, double count)
{
    char text[32];
    int  length = snprintf(text, sizeof text, "%.0f", count);
    for (int n = 0; n < length; n++) {
        if (n && (length - n) % 3 == 0 && length > 4) fputs(THIN, to);
        fputc(text[n], to);
    }
}

void html_bar(FILE *to, double share)
{
    fprintf(to, "<i style=\"width:%.1f%%\"></i>", 100 * share);
}

/* pictures -------------------------------------------------------------------------------------------------------------------- */

static void base64(FILE *to, const uint8_t *bytes, size_t count)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t n = 0; n < count; n += 3) {
        size_t   left = count - n;
        uint32_t bits = (uint32_t)bytes[n] << 16;
        if (left > 1) bits |= (uint32_t)bytes[n + 1] << 8;
        if (left > 2) bits |= bytes[n + 2];
        fputc(digits[bits >> 18], to);
        fputc(digits[bits >> 12 & 63], to);
        fputc(left > 1 ? digits[bits >> 6 & 63] : '=', to);
        fputc(left > 2 ? digits[bits & 63] : '=', to);
    }
}

vxs_result html_png(FILE *to, const uint8_t *pixels, uint32_t width_px, uint32_t height_px, uint32_t channels, const char *alt,
                    message *m)
{
    size_t   size_bytes;
    uint8_t *png = png_encode(pixels, width_px, height_px, channels, &size_bytes);
    if (!png) return fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u pixels", width_px, height_px);
    fprintf(to, "<img%s width=\"%u\" height=\"%u\" alt=\"", width_px < 512 ? " class=\"few\"" : "", width_px, height_px);
    html_text(to, alt);
    fputs("\" src=\"data:image/png;base64,", to);
    base64(to, png, size_bytes);
    fputs("\">\n", to);
    free(png);
    return VXS_OK;
}
