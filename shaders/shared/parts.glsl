// The parts of a blade, as numbered in meshes, maps and the part-id pass.

#define TG_PART_OTHER 0
#define TG_PART_JI 1
#define TG_PART_SHINOGI_JI 2
#define TG_PART_HA 3
#define TG_PART_MUNE 4
#define TG_PART_KISSAKI 5
#define TG_PART_BOSHI 6
#define TG_PART_NAKAGO 7
#define TG_PART_COUNT 8
