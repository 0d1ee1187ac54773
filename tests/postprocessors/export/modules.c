/* Lets LinuxCNC load realtime modules from the folder HEXCITE_MODULES instead of its own, which only root may write to. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef void *(*open_function)(const char *, int);

void *dlopen(const char *file, int mode)
{
    open_function real = (open_function)dlsym(RTLD_NEXT, "dlopen");
    const char *folder = getenv("HEXCITE_MODULES");
    const char *name = file ? strrchr(file, '/') : NULL;
    char ours[4096];

    if (folder && name && strstr(file, "/linuxcnc/modules/")) {
        snprintf(ours, sizeof(ours), "%s%s", folder, name);
        if (access(ours, R_OK) == 0)
            return real(ours, mode);
    }
    return real(file, mode);
}
