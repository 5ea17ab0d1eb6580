# SPDX-License-Identifier: Apache-2.0
# the probe stream, its editing, points and cells
stream_sources = \
	%D%/cells.c %D%/cells.h \
	%D%/common_options.c %D%/common_options.h \
	%D%/light_columns.c %D%/light_columns.h \
	%D%/faces.c %D%/faces.h \
	%D%/header_number.c %D%/header_number.h \
	%D%/points.c %D%/points.h \
	%D%/sight_key.c %D%/sight_key.h \
	%D%/stream.h \
	%D%/stream_binary.c \
	%D%/stream_checksum.c \
	%D%/stream_edit.c %D%/stream_edit.h \
	%D%/stream_fill.c %D%/stream_fill.h \
	%D%/stream_format.c \
	%D%/stream_gather.c %D%/stream_gather.h \
	%D%/stream_private.h \
	%D%/stream_reader.c \
	%D%/stream_salvage.c %D%/stream_salvage.h \
	%D%/stream_text.c \
	%D%/stream_valid.c \
	%D%/stream_whole.c \
	%D%/stream_writer.c \
	%D%/table.c %D%/table.h %D%/table_private.h
