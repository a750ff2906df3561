// Browser storage of the page: preferences, in the format of the desktop's file, and the last
// recordings. Without storage nothing is kept.
const PREFERENCES = 'msd.preferences';
// Number of recordings, beyond which the oldest are deleted.
const MOST = 20;

export function preferences() {
  try {
    return localStorage.getItem(PREFERENCES) ?? undefined;
  } catch {
    return undefined;
  }
}

export function keepPreferences(text) {
  try {
    localStorage.setItem(PREFERENCES, text);
  } catch {
    // Full, or not allowed here.
  }
}

const result = request => new Promise((done, failed) => {
  request.onsuccess = () => done(request.result);
  request.onerror = () => failed(request.error);
});

async function store(mode) {
  const request = indexedDB.open('msd', 2);
  request.onupgradeneeded = () => upgrade(request.result, request.transaction);
  const base = await result(request);
  const transaction = base.transaction('files', mode);
  transaction.oncomplete = () => base.close();
  return transaction.objectStore('files');
}

// Stores recordings by date and name, so that the list does not load their bytes. Rows of version 1
// have all three.
function upgrade(base, transaction) {
  const files = base.createObjectStore('files');
  if (!base.objectStoreNames.contains('recordings')) return;
  transaction.objectStore('recordings').openCursor().onsuccess = ({ target: { result: cursor } }) => {
    if (!cursor) return base.deleteObjectStore('recordings');
    const { name, bytes, date } = cursor.value;
    files.put(bytes, [date, name]);
    cursor.continue();
  };
}

export async function keepRecording(name, bytes) {
  const files = await store('readwrite');
  await result(files.put(bytes, [Date.now(), name]));
  const keys = await result(files.getAllKeys());
  for (const key of keys.slice(0, -MOST)) files.delete(key);
}

// Returns dates and names of the recordings, the newest first.
export async function recordings() {
  const keys = await result((await store('readonly')).getAllKeys());
  return keys.reverse();
}

export async function recording(key) {
  return result((await store('readonly')).get(key));
}
