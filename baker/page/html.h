/* A page that stands alone: HTML with its style in it, and pictures as data. It asks for nothing over a network.
 *
 * Own text is printed as it is; whatever comes from a file goes through html_text.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HTML_H
#define HTML_H

#include <stdint.h>
#include <stdio.h>

#include "baker/base/message.h"

/* Everything before the contents, and after. title: text, not HTML. */
void html_begin(FILE *to, const char *title);
void html_end(FILE *to);

/* Text of any bytes, made harmless between tags and in quoted attributes: < > & " ' become references, and what is not UTF-8 or no
 * character of HTML becomes '?'. */
void html_text(FILE *to, const char *text);

/* The same, of a printf. Cut after 1023 bytes. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
void html_textf(FILE *to, const char *format, ...);

/* A picture as an img element whose bytes are in the page.
 * pixels  as png_encode takes them;   alt  text, for those who do not see it.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result html_png(FILE *to, const uint8_t *pixels, uint32_t width_px, uint32_t height_px, uint32_t channels, const char *alt,
                    message *m);

/* A bar of `share`, [0, 1], of a table's cell. */
void html_bar(FILE *to, double share);

/* As size_text has it, with a space that does not break. bytes: not negative. */
void html_bytes(FILE *to, double bytes);

/* "940 ms", "6.2 s", "12 min" likewise; "0". */
void html_seconds(FILE *to, double seconds);

/* "1 234 567", narrow spaces between thousands. */
void html_count(FILE *to, double count);

/* "0.063 %", of a share of 1. */
void html_percent(FILE *to, double share);

/* The same as text. Each returns text. */
const char *seconds_text(char text[32], double seconds);
const char *percent_text(char text[32], double share);

/* Text as html_text understands it, from bytes of anywhere: in UTF-8 without control characters and noncharacters; those and broken
 * bytes become '?'. Returns text. */
char *clean_text(char *text);

#endif
