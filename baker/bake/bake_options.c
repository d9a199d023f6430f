/* Options as JSON; see bake_options.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_options.h"

static int set_word(json_t *object, const char *key, const char *choices, int index)
{
    char word[32];
    return json_object_set_new(object, key, json_string(choice_word(word, choices, index)));
}

json_t *bake_choices_json(const bake_options *o)
{
    json_t *object = json_object();
    set_word(object, "closed", CLOSED_CHOICES, (int)o->closed);
    set_word(object, "exit", EXIT_CHOICES, (int)o->exit);
    set_word(object, "rule", RULE_CHOICES, (int)o->rule);
    set_word(object, "stop", STOP_CHOICES, (int)o->stop);
    return object;
}

json_t *bake_options_json(const bake_options *o)
{
    json_t       *object = bake_choices_json(o);
    const double *b      = o->region_ws;
    set_word(object, "reuse", REUSE_CHOICES, o->reuse);
    set_word(object, "compress", COMPRESS_CHOICES, (int)o->compress);
    set_word(object, "gl", GL_CHOICES, (int)o->gl);
    set_word(object, "baseline", BASELINE_CHOICES, (int)o->baseline);
    json_object_set_new(object, "zstd_level", json_integer(o->zstd_level));
    json_object_set_new(object, "threads", json_integer(o->threads));
    if (o->memory_bytes) json_object_set_new(object, "memory_bytes", json_integer((json_int_t)o->memory_bytes));
    if (o->region_given) json_object_set_new(object, "region_m", json_pack("[f,f,f,f,f,f]", b[0], b[1], b[2], b[3], b[4], b[5]));
    return object;
}

compress_order compress_order_of(compress_choice choice)
{
    return choice == COMPRESS_CHOICE_BOTTOM_UP ? COMPRESS_BOTTOM_UP : COMPRESS_TOP_DOWN;
}

build_options build_options_of(const bake_options *o, compress_order compress)
{
    /* parts that are alike are kept once where the merge would find them anyway; what is left side by side is kept as insertion made it */
    return (build_options){.rule     = o->rule,
                           .reuse    = o->reuse,
                           .compress = o->stop == STOP_INSERT ? COMPRESS_NONE : compress,
                           .share    = o->reuse && o->stop == STOP_FINAL};
}
