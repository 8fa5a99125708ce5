// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
async function filesOfEntry(entry: FileSystemEntry): Promise<File[]> {
  if (entry.isFile)
    return new Promise((resolve, reject) =>
      (entry as FileSystemFileEntry).file((file) => resolve([file]), reject));
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  const files: File[] = [];
  for (;;) {
    const entries = await new Promise<FileSystemEntry[]>((resolve, reject) =>
      reader.readEntries(resolve, reject));
    if (entries.length === 0) return files;
    for (const inner of entries) if (inner.isFile) files.push(...(await filesOfEntry(inner)));
  }
}

/** The files that were dropped; of folders those directly in them. */
async function droppedFiles(transfer: DataTransfer): Promise<File[]> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.() ?? null);
  if (!entries.some((entry) => entry?.isDirectory)) return [...transfer.files];
  const lists = await Promise.all(entries.map((entry) => (entry ? filesOfEntry(entry) : [])));
  return lists.flat();
}

/** Lets files be dropped anywhere on the page. */
export function acceptDrops(onFiles: (files: File[]) => void, onFailure: (message: string) => void): void {
  let depth = 0; // elements under the pointer
  const mark = (): void => void document.body.classList.toggle("is-drop-target", depth > 0);
  addEventListener("dragenter", (event) => {
    event.preventDefault();
    ++depth;
    mark();
  });
  addEventListener("dragleave", () => {
    depth = Math.max(0, depth - 1);
    mark();
  });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    depth = 0;
    mark();
    if (event.dataTransfer)
      droppedFiles(event.dataTransfer).then(
        (files) => (files.length > 0 ? onFiles(files) : onFailure("There is no file in it.")),
        // Of pages that were opened from a disk Chromium keeps folders away.
        () => onFailure("This browser does not let the page read the folder. Choose its files by “Open”."),
      );
  });
}
