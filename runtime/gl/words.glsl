/* Fetch of a word from the array of all words. Compiled behind the constants of gl_object.c (write_head). */
#ifdef GL_ES
precision highp float;
precision highp int;
precision highp usampler2D;
#endif
#ifdef VXS_GL_BUFFERS
layout(std430, binding = VXS_GL_AT_WORDS) readonly restrict buffer vxs_words_block { uint vxs_words[]; };
#define VXS_GL_LAST_WORD (uint(vxs_words.length()) - 1u)
#define vxs_word(dag, i) vxs_words[min((dag) + (i), VXS_GL_LAST_WORD)]
#else
uniform usampler2D vxs_words;
uint vxs_fetch(uint at)
{
    at = min(at, VXS_GL_LAST_WORD);
    return texelFetch(vxs_words, ivec2(int(at & (VXS_GL_WIDE - 1u)), int(at / VXS_GL_WIDE)), 0).r;
}
#define vxs_word(dag, i) vxs_fetch((dag) + (i))
#endif
