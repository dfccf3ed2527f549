// A count that lives on the device: see device_count.h.
#ifndef DEVICE_COUNT_GLSL
#define DEVICE_COUNT_GLSL

const uint no_count_word = 0xffffffffu;

// `words` is the buffer that holds the count.
#define element_count(words, word, capacity)                                                                           \
    ((word) == no_count_word ? (capacity) : min((words)[(word) == no_count_word ? 0u : (word)], (capacity)))

#endif
