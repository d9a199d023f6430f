/* Results of all vxs functions that can fail: one list of name, fixed value, text. And the log callback that explains them.
 *
 * Values are grouped with gaps, only appended, and never reused, so that a stored value keeps its meaning.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_RESULT_H
#define VXS_RESULT_H

/* clang-format off */
#define VXS_RESULTS(X)                                                         \
    X(VXS_OK,             0, "success")                                        \
    X(VXS_E_ARGUMENT,     1, "an argument is outside its range")               \
    X(VXS_E_MEMORY,       2, "out of memory")                                  \
    X(VXS_E_READ,         3, "a file cannot be read")                          \
    X(VXS_E_WRITE,        4, "a file cannot be written")                       \
    X(VXS_E_INTERRUPTED,  5, "interrupted")                                    \
    X(VXS_E_REFERENCES,   6, "more nodes than 32-bit references reach")        \
    X(VXS_E_BROKEN_PIPE,  7, "the reader of the output is gone")                \
    X(VXS_E_NO_FILE,      8, "no such file")                                   \
    X(VXS_E_NOT_VXS,     10, "not a .vxs file")                                \
    X(VXS_E_VERSION,     11, "a format version that this library cannot read") \
    X(VXS_E_TRUNCATED,   12, "the file ends before its contents")              \
    X(VXS_E_CORRUPT,     13, "the file breaks a rule of its format")           \
    X(VXS_E_SCENE,       20, "the scene breaks a rule of glTF")                \
    X(VXS_E_UNSUPPORTED, 21, "the scene requires what vxs does not read")      \
    X(VXS_E_NO_CASTER,   22, "the scene has no triangle that casts a shadow")  \
    X(VXS_E_NO_LIGHT,    23, "the scene has no light to bake")                 \
    X(VXS_E_STRICT,      24, "a warning, where warnings are errors")           \
    X(VXS_E_GL,          30, "OpenGL is not available")                        \
    X(VXS_E_PROGRAM,     31, "a program that is needed is not available")
/* clang-format on */

typedef enum vxs_result {
#define VXS_RESULT_ENUM(name, value, text) name = value,
    VXS_RESULTS(VXS_RESULT_ENUM)
#undef VXS_RESULT_ENUM
} vxs_result;

#ifdef __cplusplus
extern "C" {
#endif

typedef enum vxs_severity {
    VXS_SEVERITY_WARNING = 1, /* the work goes on, but its result may not be what was wanted */
    VXS_SEVERITY_ERROR   = 2, /* the reason why the function will return another result than VXS_OK */
} vxs_severity;

/* The log callback of every library. Programs decide by results; this text is for people.
 * text  in English, without a newline at its end; valid during the call
 * user  as given beside the callback */
typedef void vxs_log_fn(vxs_severity severity, const char *text, void *user);

#ifdef __cplusplus
}
#endif
#endif
